// volume_error: the chamber is larger (or smaller) than its log says: dead volume of fittings and cap, or a position sensor that is
// not straight or late.
//
//   v = v_log + D + (q w^2 + s w^3) v_0 + tau v_log',   w = (v_log - v_0)/v_0
//
// v volume, v_0 the logged one's mean over the first log [m3]; D offset [m3]; q bow and s S-shape of the scale [-], of a
// potentiometer or a linkage; tau time constant of the position sensor [s], whose first order the last term undoes exactly. A
// relative error of the volume is exactly a change of both flow gains, at rest and moving, and has no figure here.
// Assumptions: all constant; v_0 is not kept with the figures, so that a rig which is saved with a bow is one of logs of the
// same mean volume; the gas of the first row is that of a chamber at rest. Vanishes at D = q = s = tau = 0. The chamber keeps
// at least a tenth of the logged volume. Numerical treatment: v_log' at a step's end is extrapolated from the chords of it and
// of the step before. Source: dead volume of "Pneumatic actuators" (5); Doebelin, Measurement Systems, 3 (linearity,
// first-order instruments).
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 4> kVolumeErrorParameters{{
    {"offset_mL", "D: true volume less the logged one", -5000.0, 5000.0, 0.0, 3.0, Coordinate::linear, false,
     kAsTheVolume},
    {"bow", "q: of the scale, over the square of the way from the mean volume", -2.0, 2.0, 0.0, 0.05,
     Coordinate::linear, true},
    {"s_shape", "s: of the scale, over the cube of that way", -5.0, 5.0, 0.0, 0.1, Coordinate::linear, true},
    {"lag_s", "tau: time constant of the position sensor", 0.0, 0.2, 0.0, 0.003, Coordinate::linear, true},
}};
inline constexpr Effect kVolumeError{
    "volume_error",
    Equation::energy,
    "the chamber holds more or less air than its logged volume says, which may be bowed or late",
    "v = v_log + D + (q w^2 + s w^3) v_0 + tau v_log', w = (v_log - v_0)/v_0",
    "dead volume of hoses and caps; linearity and lag of a position sensor",
    kVolumeErrorParameters};

template <class N>
class VolumeError {
 public:
  struct Motion {
    N volume_m3;  ///< at the middle of a step
    N rate_m3_s;
  };

  /// `x`: D, q, s, tau.
  void prepare(const N* x, double mean_m3) {
    offset_m3_ = x[0] * 1e-6;
    bow_ = x[1];
    s_shape_ = x[2];
    lag_s_ = x[3];
    mean_m3_ = mean_m3;
    moves_ = false;
  }
  /// Of a chamber at rest.
  N volume(double logged_m3) const { return larger(straight(logged_m3), N(kKept * logged_m3)); }
  /// A step passes, in which the logged volume goes from the first of these to the second, and where `another` step of the tick
  /// follows, in that to the third.
  Motion step(const double* logged_m3, bool another, double step_s) {
    const double middle_m3 = 0.5 * (logged_m3[0] + logged_m3[1]);
    const double rate_m3_s = (logged_m3[1] - logged_m3[0]) / step_s;
    if (!moves_) {
      rate_m3_s_ = another ? 2.0 * rate_m3_s - (logged_m3[2] - logged_m3[1]) / step_s : rate_m3_s;
      end_m3_s_ = 0.5 * (rate_m3_s_ + rate_m3_s);
      moves_ = true;
    }
    const double begin_m3_s = end_m3_s_;
    end_m3_s_ = 1.5 * rate_m3_s - 0.5 * rate_m3_s_;
    rate_m3_s_ = rate_m3_s;
    const N later_m3 = lag_s_ * (0.5 * (begin_m3_s + end_m3_s_));
    const double way = middle_m3 / mean_m3_ - 1.0;
    const N volume_m3 = straight(middle_m3) + later_m3, least_m3(kKept * middle_m3);
    const N actual_m3_s = rate_m3_s * (1.0 + way * (2.0 * bow_ + 3.0 * way * s_shape_)) +
                          lag_s_ * ((end_m3_s_ - begin_m3_s) / step_s);
    return {larger(volume_m3, least_m3), select(volume_m3 > least_m3, actual_m3_s, N(kKept * rate_m3_s))};
  }

 private:
  static constexpr double kKept = 0.1;  ///< of the logged volume, at least

  N straight(double logged_m3) const {
    const double way = logged_m3 / mean_m3_ - 1.0;
    return logged_m3 + offset_m3_ + mean_m3_ * way * way * (bow_ + way * s_shape_);
  }

  N offset_m3_{}, bow_{}, s_shape_{}, lag_s_{};
  double mean_m3_ = 0.0;
  double rate_m3_s_ = 0.0, end_m3_s_ = 0.0;  // of the last step: its chord, and the slope at its end
  bool moves_ = false;
};

}  // namespace plenum::host::effects
