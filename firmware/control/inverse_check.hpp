// Whether a model's inverse keeps what it promises, on a small grid of the chamber that the model is meant for.
//
//   round trip   p1 = step(p, v, u), u1 = inverse(p, p1), p2 = step(p, v, u1):      |p2 - p1| <= tolerance
//   authority    at the middle pressure     step(p, v, u_high) - p >= least,   p - step(p, v, u_low) >= least
//
// p [kPa], v [mL], u [V], all at rest (v' = 0). Every target is one that a command of the range reaches; which command the inverse
// answers is its own affair, for the formulas reach some pressures by several (README.md). It is asked from the middle of
// the range, not from the command that is known to do.
//
// Both bounds are shares of P_c - P_r.
// kTolerance: the formulas' inverse may take the limit of the range for a command that comes closer by less than 1 %
// (inverse_search.hpp); that of the grey-box model, which is asked from far off here, is up to 2.2 % off in chambers that are full
// within a tick. The README has the measurement.
// least = (P_c - P_r)/kTicksOfSpan: a valve whose full opening would take longer than 100 s for the whole span.
//
// Cost: kPointsPerTick points a call, of which each is two steps and one inverse; kPoints in all.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class InverseCheck {
 public:
  static constexpr std::size_t kVolumes = 2;
  static constexpr std::size_t kPressures = 3;
  static constexpr std::size_t kCommands = 5;
  static constexpr std::size_t kPoints = kVolumes * kPressures * kCommands;
  static constexpr std::size_t kPointsPerTick = 10;
  static constexpr Scalar kTolerance = Scalar(0.03);
  static constexpr Scalar kTicksOfSpan = Scalar(10000);

  /// What a grid spans.
  struct Range {
    Scalar pressure_low_kPa = 0, pressure_high_kPa = 0;
    Scalar volume_low_mL = 0, volume_high_mL = 0;
    Scalar command_low_V = 0, command_high_V = 0;
    Scalar span_kPa = 0;  ///< P_c - P_r of the model
  };

  /// A point of the grid: the state, the command, the pressure asked for and the one that came.
  struct Point {
    Scalar pressure_kPa = 0;
    Scalar volume_mL = 0;
    Scalar command_V = 0;
    Scalar wanted_kPa = 0;
    Scalar came_kPa = 0;
  };

  enum class Finding : std::uint8_t {
    running,
    passed,
    inverse_fails,  ///< point(): asked for `wanted`, the inverse's command led to `came`
    no_authority    ///< point(): the command at an end of the range led to `came`, at least `wanted` was due
  };

  /// A new check.
  void begin(const Range& range) noexcept {
    range_ = range;
    next_ = 0;
  }
  /// The next kPointsPerTick points. `model` is bound to the commands of the range.
  Finding step(const PressureModel& model) noexcept;
  /// Where it failed.
  const Point& point() const noexcept { return point_; }

 private:
  Finding look_at(const PressureModel& model, std::size_t number) noexcept;

  Range range_;
  Point point_;
  std::size_t next_ = 0;
};

}  // namespace plenum::control
