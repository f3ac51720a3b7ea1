// A board: the controller wired to its ports. The same wiring runs on the real drivers and on the simulated
// ones.
//
// Whoever owns the drivers calls, in one thread:
//   start()            once, before the first tick: models come from the store
//   handle_frames()    whenever frames may have come, also between ticks
//   tick()             every config::kTick_s
//   store_changed()    after each tick: a piece of storing, of at most one write or one sync
#pragma once

#include "firmware/config/twice.hpp"
#include "firmware/controller.hpp"
#include "firmware/parameter_keeper.hpp"
#include "firmware/ports/analog.hpp"
#include "firmware/ports/can_bus.hpp"
#include "firmware/ports/digital_io.hpp"
#include "firmware/ports/parameter_store.hpp"
#include "firmware/tick_timing.hpp"

namespace plenum {

/// Channels of the analog input, in order: pressures, positions, supply.
inline constexpr std::size_t kAnalogInputs = 2 * config::kChambers + 1;

struct Drivers {
  ports::AnalogInput& analog_in;
  ports::AnalogOutput& analog_out;
  ports::DigitalIo& digital;
  ports::CanBus& can;
  ports::ParameterStore& store;
};

class Board {
 public:
  /// The drivers must outlive the board.
  Board(const Settings& settings, const Drivers& drivers) noexcept
      : controller_(settings),
        drivers_(drivers),
        keeper_(drivers.store),
        configuration_refused_(settings.configuration_refused ? 1 : 0) {}
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;

  /// Loads the stored set. Whatever is damaged, the board runs and can be reached.
  void start() noexcept;

  /// Takes every waiting frame, at most kFramesAtOnce, and sends the answers.
  void handle_frames() noexcept;

  /// One tick.
  void tick(const TickTiming& timing) noexcept;

  /// Moves the storing of what has changed on by one bounded piece (ParameterKeeper). Costs next to nothing when
  /// nothing is to be stored.
  void store_changed() noexcept;

  /// What LSS has stored: the bit rate to run the bus at, once start() has read it.
  const config::LssSettings& lss() const noexcept { return keeper_.lss(); }

  const Controller& controller() const noexcept { return controller_; }

  static constexpr int kFramesAtOnce = 64;

 private:
  void send_frames() noexcept;

  Controller controller_;
  Drivers drivers_;
  ParameterKeeper keeper_;
  config::Twice<std::uint8_t> configuration_refused_;  ///< 1: it is, if either copy says so
  bool outputs_ok_ = true;
  std::uint32_t lost_before_ = 0;  ///< frames the driver had lost at the last tick
  ports::CanFrame unsent_{};
  bool has_unsent_ = false;  ///< the driver's queue was full: this frame goes first next time
};

}  // namespace plenum
