// volume_error: the chamber is larger (or smaller) than its log says: dead volume of fittings and cap, or a position sensor that is
// late.
//
//   v = v_log + D + tau v_log'
//
// v volume [m3]; D offset [m3]; tau time constant of the position sensor [s], whose first order the last term undoes exactly.
// A relative error of the volume is exactly a change of both flow gains, at rest and moving, and has no figure here. Assumptions: both
// constant. Vanishes at D = tau = 0. The chamber keeps at least a tenth of the logged volume. Numerical treatment: v_log' of a
// step is its chord, which the volume's rate takes over at the step's beginning. Source: dead volume of "Pneumatic actuators" (5);
// Doebelin, Measurement Systems, 3 (first-order instruments).
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kVolumeErrorParameters{{
    {"offset_mL", "D: true volume less the logged one", -5000.0, 5000.0, 0.0, 3.0, Coordinate::linear, false,
     kAsTheVolume},
    {"lag_s", "tau: time constant of the position sensor", 0.0, 0.2, 0.0, 0.003, Coordinate::linear, true},
}};
inline constexpr Effect kVolumeError{
    "volume_error",
    Equation::energy,
    "the chamber holds more or less air than its logged volume says, which may come late",
    "v = v_log + D + tau v_log'",
    "dead volume of hoses and caps; lag of a position sensor",
    kVolumeErrorParameters};

template <class N>
class VolumeError {
 public:
  struct Motion {
    N volume_m3;  ///< at the middle of a step
    N rate_m3_s;
  };

  /// `x`: D, tau.
  void prepare(const N* x) {
    offset_m3_ = x[0] * 1e-6;
    lag_s_ = x[1];
    moves_ = false;
  }
  /// Of a chamber at rest.
  N volume(double logged_m3) const { return larger(logged_m3 + offset_m3_, N(0.1 * logged_m3)); }
  /// A step passes, in which the logged volume goes from one to the other.
  Motion step(double from_m3, double to_m3, double step_s) {
    const double middle_m3 = 0.5 * (from_m3 + to_m3), rate_m3_s = (to_m3 - from_m3) / step_s;
    const double before_m3_s = moves_ ? rate_m3_s_ : rate_m3_s;
    rate_m3_s_ = rate_m3_s;
    moves_ = true;
    const N later_m3 = lag_s_ * (0.5 * (before_m3_s + rate_m3_s));
    return {larger(middle_m3 + offset_m3_ + later_m3, N(0.1 * middle_m3)),
            rate_m3_s + lag_s_ * ((rate_m3_s - before_m3_s) / step_s)};
  }

 private:
  N offset_m3_{}, lag_s_{};
  double rate_m3_s_ = 0.0;
  bool moves_ = false;
};

}  // namespace plenum::host::effects
