// When ticks are due. Pure: it is told the time and never asks for it.
//
// By the clock: tick k is due at start + k periods.
//
// By the scans: a tick is due as soon as the converter has brought a tick's worth of them. Its own crystal so sets the rate,
// and a reading is never older than the moment that it takes to be read. When the scans stay away, the clock stands in: half a
// period after the tick was expected, then every period, until scans come again. A converter that stands still thus still
// gives ticks, with readings that are not fresh, and the firmware makes a fault of them.
//
// Latency is counted from the moment a tick was due. By the scans that is the earliest phase seen, one period on, which may
// slip by kDrift: what is kept is how much later than its best a tick begins, whatever the two crystals are worth. A converter
// slower than kDrift falls behind a whole period now and then, and that is an overrun in truth. One that is faster than it was
// said to be gains kAdvance a tick at most, and what it brings beyond is averaged, too: the model's tick is no shorter.
//
// Overrun: a tick that begins a period or more after it was due. The ones that went by are left out and counted.
#pragma once

#include <cstdint>
#include <optional>

namespace plenum::board::rt {

class Pace {
 public:
  /// By the scans: the rate of two crystals may differ by one part in kDrift.
  static constexpr std::uint64_t kDrift = 5000;
  /// By the scans: a tick begins by one part in kAdvance of a period before it is due, and no sooner.
  static constexpr std::uint64_t kAdvance = 100;

  struct Config {
    std::uint64_t period_ns = 10'000'000;
    bool by_scans = false;
  };

  struct Tick {
    std::uint64_t latency_ns = 0;  ///< from the moment it was due
    std::uint32_t missed = 0;      ///< ticks that were due before and never began
  };

  /// The first tick is due a period after `now_ns`.
  Pace(const Config& config, std::uint64_t now_ns) noexcept
      : config_(config), due_ns_(now_ns + config.period_ns) {}

  /// When the clock calls for a tick, if until then the scans stay as they are. `scans_ready`: a tick's worth of them has come.
  std::uint64_t deadline_ns(bool scans_ready) const noexcept {
    if (!by_scans_now_) return due_ns_;
    return scans_ready ? due_ns_ - config_.period_ns / kAdvance : due_ns_ + config_.period_ns / 2;
  }

  /// The tick that is to begin now; empty: none yet.
  std::optional<Tick> due(std::uint64_t now_ns, bool scans_ready) noexcept;

 private:
  Config config_;
  std::uint64_t due_ns_;       ///< of the next tick
  bool by_scans_now_ = false;  ///< the last tick began with its scans
};

}  // namespace plenum::board::rt
