// Valve commands for identification: everything that c1..c9 need to be told apart, inside pressure limits.
//
// No model and no reference are needed. (The paper excited its robot by a PID on random joint targets; a
// controller correlates command with pressure, and seldom dwells near the null.) The command is a sequence of
// random segments:
//
//   1/2  a level, uniform over the command range, 20..400 ms           s(u), r(u): c2, c3, c7, c8
//   1/4  a level within a tenth of the range about the null, 50..400 ms  the leaky regime: c1, c9
//   1/8  a ramp to a uniform level, 0.2..1.5 s                         s(u) nearly at rest: c2, c3
//   1/8  a full stroke to alternate ends, 20..120 ms                   the largest rates: c7, c8
//
// The guard shapes the command that a segment asks for:
//  - within `approach` of a limit the valve may open towards it only in proportion to the room left;
//  - beyond a limit, projected to the end of the coming tick, the valve opens to the other side, as far as leads to the
//    middle of the range in a tick (in most chambers fully); from there at least a quarter, until the pressure has come
//    back by the hysteresis. The upper limit prevails.
//
// `approach` is what the chamber can do in two ticks at full opening: the configured value, or twice the
// fastest change seen so far where that is more; what exceeds the range is forgotten within seconds.
//
// A wall that moves faster than the open valve can answer still takes the pressure past a limit: the trip of
// firmware/safety stands behind this guard.
//
// The command never leaves [command_low_V, command_high_V], and a pressure that is not finite gives null_V.
// The same seed and pressures give the same commands, bit for bit.
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/config/chamber_settings.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::control {

using numeric::Scalar;

class Excitation {
 public:
  struct Config {
    std::uint32_t seed = 1;  ///< any value; chambers of one board get different ones
    Scalar command_low_V = Scalar(3);
    Scalar command_high_V = Scalar(7);
    Scalar null_V = Scalar(5);  ///< between the two; above it the supply port opens
    Scalar pressure_low_kPa = Scalar(130);
    Scalar pressure_high_kPa = Scalar(600);
    Scalar approach_kPa =
        Scalar(100);  ///< least distance from a limit at which the guard begins to close the valve
    Scalar hysteresis_kPa = Scalar(30);  ///< how far the pressure is brought back from a limit
  };

  /// Takes a configuration as given by restrict_to(), and starts its sequence from the beginning.
  void configure(const Config& config) noexcept;

  /// The command [V] for the tick to come, from the absolute pressure [kPa] averaged over the tick just past.
  Scalar step(Scalar pressure_kPa) noexcept;

 private:
  enum class Force : std::uint8_t { none, exhaust, supply };
  struct Room {
    Scalar above_kPa;  // up to the upper limit
    Scalar below_kPa;  // down to the lower limit
  };

  std::uint32_t random() noexcept;
  Scalar uniform(Scalar low, Scalar high) noexcept;
  std::uint32_t ticks_between(std::uint32_t low, std::uint32_t high) noexcept;
  void begin_segment() noexcept;
  Scalar guard(Scalar wanted_V, Scalar pressure_kPa) noexcept;
  Room room_at_tick_end(Scalar pressure_kPa) noexcept;
  // -1 at command_low_V, 0 at null_V, 1 at command_high_V; and back.
  Scalar opening(Scalar command_V) const noexcept;
  Scalar command_V(Scalar opening) const noexcept;

  Config config_;
  std::uint32_t random_ = 1;  // never 0
  std::uint32_t ticks_left_ = 0;
  Scalar level_V_ = Scalar(5);  // what the segment asks for
  Scalar slope_V_ = 0;          // a tick
  bool stroke_up_ = false;
  bool has_pressure_ = false;
  Scalar pressure_before_kPa_ = 0;
  Scalar approach_kPa_ = Scalar(100);
  Scalar command_V_ = Scalar(5);  // now held at the valve
  Scalar command_before_V_ = Scalar(5);
  Force force_ = Force::none;
};

/// `asked`, brought inside what the installer allows: commands and pressures within the limits of `settings`,
/// null_V of `settings`. Nothing where that leaves a command or pressure range that is empty or does not reach both sides of the
/// null, or where a limit is not a number: whoever asked meant something else.
std::optional<Excitation::Config> restrict_to(const Excitation::Config& asked,
                                              const config::ChamberSettings& settings) noexcept;

}  // namespace plenum::control
