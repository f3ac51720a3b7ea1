// The loop of the board: waits, takes frames as they come, and makes a tick when one is due.
//
//     wait for: frames | scans | emergency stop | deadline of the pace | SIGTERM
//       emergency stop:  valve power off at once
//       scans:           taken into the sums of the tick
//       tick due?   yes: frames, tick, a piece of storing, watchdogs, bus     no: frames
//       SIGTERM, or the guard has ended:  outputs safe, what is being stored is finished, end
//
// One thread, no heap, no exception while a bus is there. Everything beyond the firmware's ports is Events and Hardware, so
// that a test runs the very loop on a clock of its own.
#pragma once

#include <cstdint>

#include "board/config/board_file.hpp"
#include "board/rt/events.hpp"
#include "board/rt/pace.hpp"
#include "firmware/board.hpp"

namespace plenum::board {

/// The board beyond what the firmware knows of it.
class Hardware {
 public:
  /// Ticks begin: what the converters have brought before is of none.
  virtual void begin() noexcept = 0;
  /// Takes the scans that wait. Whether there were any.
  virtual bool gather() noexcept = 0;
  /// A tick's worth of scans has come since the readings were read.
  virtual bool scans_ready() const noexcept = 0;
  /// The line of the emergency stop has changed.
  virtual void look_at_stop() noexcept = 0;
  /// Somebody makes the outputs safe if the loop ends or falls silent.
  virtual bool guarded() const noexcept = 0;
  /// A tick has been done, the `tick_count`-th: feeds watchdogs, tends the bus.
  virtual void ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept = 0;
  /// Outputs at their safe values, valve power off.
  virtual void make_safe() noexcept = 0;
  /// What the output of a chamber is to hold at rest from now on [V].
  virtual void rest_at(std::size_t chamber, float command_V) noexcept = 0;
  /// There will be no tick any more; what is being stored is still to be finished.
  virtual void stopping() noexcept = 0;

 protected:
  ~Hardware() = default;
};

class Plenumd {
 public:
  /// Waits that drivers end between two ticks; beyond, they wait for the next tick. More than a full bus brings, and a bound
  /// on what a driver gone mad can take.
  static constexpr int kWaits = 512;
  /// Time for what is being stored when the loop is stopped.
  static constexpr int kFinish_ms = 2000;

  /// All must outlive it. `board` has been started.
  Plenumd(const config::RealTime& real_time, Board& board, rt::Events& events, Hardware& hardware) noexcept;

  /// Until a signal asks to stop, or the guard is lost; the outputs are safe before the first tick and after the last.
  void run() noexcept;

 private:
  /// False: asked to stop, or no guard stands any more.
  bool step() noexcept;
  void tick(const rt::Pace::Tick& tick, std::uint64_t now_ns) noexcept;
  void finish_storing() noexcept;

  Overrun overrun_;
  Board& board_;
  rt::Events& events_;
  Hardware& hardware_;
  rt::Pace pace_;
  std::uint64_t scans_ns_;  ///< when scans have come last
  int waits_ = 0;           ///< since the last tick
};

}  // namespace plenum::board
