// volume_error: the chamber is larger (or smaller) than its log says: dead volume of fittings and cap, or a position sensor that is
// not straight or late.
//
//   v = v_l + D + (q w^2 + s w^3) v_0 + tau v_l',   v_l(t) = v_log(t + d),   w = (v_l - v_0)/v_0
//
// v volume, v_0 the logged one's mean over the first log [m3]; D offset [m3]; q bow and s S-shape of the scale [-], of a
// potentiometer or a linkage; tau time constant of the position sensor [s], whose first order the last term undoes exactly; d
// dead time of the sensor or of what carries its readings [s]. A relative error of the volume is exactly a change of both
// flow gains, at rest and moving, and has no figure here. Assumptions: all constant; v_0 is not kept with the figures, so that a
// rig which is saved with a bow is one of logs of the same mean volume; the gas of the first row is that of a chamber at rest.
// Vanishes at D = q = s = tau = d = 0. The chamber keeps at least a tenth of the logged volume. Numerical treatment: v_l is
// straight between the steps of the log and goes on beyond its end as it last moved; v_l' at a step's end is extrapolated
// from the chords of it and of the step before. Source: dead volume of "Pneumatic actuators" (5); Doebelin, Measurement
// Systems, 3 (linearity, first-order instruments, dead time).
#pragma once

#include <array>
#include <span>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 5> kVolumeErrorParameters{{
    {"offset_mL", "D: true volume less the logged one", -5000.0, 5000.0, 0.0, 3.0, Coordinate::linear, false,
     kAsTheVolume},
    {"bow", "q: of the scale, over the square of the way from the mean volume", -2.0, 2.0, 0.0, 0.05,
     Coordinate::linear, true},
    {"s_shape", "s: of the scale, over the cube of that way", -5.0, 5.0, 0.0, 0.1, Coordinate::linear, true},
    {"lag_s", "tau: time constant of the position sensor", 0.0, 0.2, 0.0, 0.003, Coordinate::linear, true},
    {"delay_s", "d: dead time of the position sensor", 0.0, 0.2, 0.0, 0.003, Coordinate::linear, true},
}};
inline constexpr std::size_t kVolumeDelay = 4;  ///< d among these
static_assert(kVolumeErrorParameters[kVolumeDelay].name == "delay_s");
inline constexpr Effect kVolumeError{
    "volume_error",
    Equation::energy,
    "the chamber holds more or less air than its logged volume says, which may be bowed or late",
    "v = v_l + D + (q w^2 + s w^3) v_0 + tau v_l', v_l(t) = v_log(t + d), w = (v_l - v_0)/v_0",
    "dead volume of hoses and caps; linearity, lag and dead time of a position sensor",
    kVolumeErrorParameters};

template <class N>
class VolumeError {
 public:
  struct Motion {
    N volume_m3;  ///< at the middle of a step
    N rate_m3_s;
  };

  /// `x`: D, q, s, tau, d.
  void prepare(const N* x, double mean_m3) {
    offset_m3_ = x[0] * 1e-6;
    bow_ = x[1];
    s_shape_ = x[2];
    lag_s_ = x[3];
    delay_s_ = x[kVolumeDelay];
    delayed_ = any(x[kVolumeDelay] > N(0.0));
    mean_m3_ = mean_m3;
    moves_ = false;
  }
  /// Of a chamber at rest.
  N volume(double logged_m3) const {
    const N logged(logged_m3);
    return larger(straight(logged, logged * (1.0 / mean_m3_) - 1.0), kKept * logged);
  }
  /// A step passes, in which the logged volume goes from the first of these to the second; as far as it is known it goes on to the
  /// others.
  Motion step(std::span<const double> logged_m3, double step_s) {
    const N begin_m3 = logged_at(logged_m3, 0, step_s), next_m3 = logged_at(logged_m3, 1, step_s);
    const N middle_m3 = 0.5 * (begin_m3 + next_m3);
    const N rate_m3_s = (next_m3 - begin_m3) * (1.0 / step_s);
    if (!moves_) {
      rate_m3_s_ = 2.0 * rate_m3_s - (logged_at(logged_m3, 2, step_s) - next_m3) * (1.0 / step_s);
      end_m3_s_ = 0.5 * (rate_m3_s_ + rate_m3_s);
      moves_ = true;
    }
    const N begin_m3_s = end_m3_s_;
    end_m3_s_ = 1.5 * rate_m3_s - 0.5 * rate_m3_s_;
    rate_m3_s_ = rate_m3_s;
    const N way = middle_m3 * (1.0 / mean_m3_) - 1.0;
    const N volume_m3 = straight(middle_m3, way) + lag_s_ * (0.5 * (begin_m3_s + end_m3_s_));
    const N least_m3(kKept * 0.5 * (logged_m3[0] + logged_m3[1]));
    const N actual_m3_s = rate_m3_s * (1.0 + way * (2.0 * bow_ + 3.0 * way * s_shape_)) +
                          lag_s_ * ((end_m3_s_ - begin_m3_s) * (1.0 / step_s));
    return {larger(volume_m3, least_m3), select(volume_m3 > least_m3, actual_m3_s,
                                                N(kKept * (logged_m3[1] - logged_m3[0]) * (1.0 / step_s)))};
  }

 private:
  static constexpr double kKept = 0.1;  ///< of the logged volume, at least

  N straight(const N& logged_m3, const N& way) const {
    return logged_m3 + offset_m3_ + mean_m3_ * way * way * (bow_ + way * s_shape_);
  }
  /// v_l after so many steps.
  N logged_at(std::span<const double> logged_m3, std::size_t steps, double step_s) const {
    const std::size_t last = logged_m3.size() - 1;
    const auto at = [&](std::size_t k) {
      if (k <= last) return logged_m3[k];
      return logged_m3[last] + static_cast<double>(k - last) * (logged_m3[last] - logged_m3[last - 1]);
    };
    if (!delayed_) return N(at(steps));
    return each(delay_s_, [&](double delay_s) {
      const double later = delay_s / step_s, whole = std::floor(later);
      const std::size_t k = steps + static_cast<std::size_t>(whole);
      return at(k) + (later - whole) * (at(k + 1) - at(k));
    });
  }

  N offset_m3_{}, bow_{}, s_shape_{}, lag_s_{}, delay_s_{};
  bool delayed_ = false;
  double mean_m3_ = 0.0;
  N rate_m3_s_{}, end_m3_s_{};  // of the last step: its chord, and the slope at its end
  bool moves_ = false;
};

}  // namespace plenum::host::effects
