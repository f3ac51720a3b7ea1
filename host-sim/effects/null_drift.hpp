// null_drift: the valve's null moves during the run, as its coil warms or its supply pressure settles.
//
//   x = u - d(t),   d(t) = D (1 - e^(-t/tau)) / (1 - e^(-T/tau)) + sum_k W_k B(t/H - k),  k = 1, 2.. 20
//
// u command, x effective command [V]; D drift reached at T = 60 s [V]; tau time constant [s], infinite for a ramp; W_k
// refine it where the null wanders [V]: the coefficients of a cubic spline with a knot each H, B its basis function, which
// is 2/3 at 0 and vanishes beyond 2. From the 20th on they are alike, so that after 21 H W_20 stands; W_1/6 at t = 0 belongs to
// the thresholds. H is given, not found, and one for all lanes: 3 s, or a twentieth of a longer log. Assumptions: both ports move
// together; t counts from the first row of a log. Vanishes at D = W_k = 0. Numerical treatment: held over a tick; the exponential is
// carried from tick to tick. Source: warm-up of proportional solenoids; de Boor, A Practical Guide to Splines (1978).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"
#include "host-sim/effects/warm_up.hpp"

namespace plenum::host::effects {

inline constexpr std::size_t kNullKnots = 20;
inline constexpr double kLeastKnot_s = kWarmUpReference_s / kNullKnots;
inline constexpr std::array<Parameter, 3 + kNullKnots> kNullDriftParameters{{
    {"drift_at_60_s_V", "shift of the null after a minute", -1.5, 1.5, 0.0, 0.1},
    {"time_constant_s", "of its approach; infinite for a ramp", 2.0, kInfinity, kInfinity, 0.05,
     Coordinate::reciprocal},
    {"wander_1_V", "W_1, about H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_2_V", "W_2, about 2 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_3_V", "W_3, about 3 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_4_V", "W_4, about 4 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_5_V", "W_5, about 5 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_6_V", "W_6, about 6 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_7_V", "W_7, about 7 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_8_V", "W_8, about 8 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_9_V", "W_9, about 9 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_10_V", "W_10, about 10 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_11_V", "W_11, about 11 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_12_V", "W_12, about 12 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_13_V", "W_13, about 13 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_14_V", "W_14, about 14 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_15_V", "W_15, about 15 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_16_V", "W_16, about 16 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_17_V", "W_17, about 17 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_18_V", "W_18, about 18 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_19_V", "W_19, about 19 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wander_20_V", "W_20, about 20 H", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"knot_s", "H, given: between knots of the spline", kLeastKnot_s, 10000.0, kLeastKnot_s, 1.0,
     Coordinate::linear, true},
}};
inline constexpr Effect kNullDrift{"null_drift",
                                   Equation::command,
                                   "the command at which the valve is shut moves during the run",
                                   "x = u - D (1 - e^(-t/tau)) / (1 - e^(-60 s/tau)) - spline",
                                   "warm-up of proportional solenoids",
                                   kNullDriftParameters};

template <class N>
class NullDrift {
 public:
  void prepare(const N* x, double tick_s) {
    warm_up_V_.prepare(x[0], x[1], tick_s);
    wander_V_ = x + 2;
    knot_s_ = lane(x[2 + kNullKnots], 0);
    drift_V_ = wander_V(0.0);
    tick_s_ = tick_s;
    time_s_ = 0.0;
  }
  N at(const N& command) const { return command - drift_V_; }
  void end_tick() {
    warm_up_V_.end_tick();
    time_s_ += tick_s_;
    drift_V_ = warm_up_V_.drift() + wander_V(time_s_ / knot_s_);
  }

 private:
  /// The spline, `at` in knots.
  N wander_V(double at) const {
    const double left = std::floor(at);
    const double s = at - left, r = 1.0 - s;
    const std::array<double, 4> basis{r * r * r / 6.0, 2.0 / 3.0 - s * s * (1.0 - 0.5 * s),
                                      2.0 / 3.0 - r * r * (1.0 - 0.5 * r), s * s * s / 6.0};
    N sum(0.0);
    for (int i = 0; i < 4; ++i) {
      const int knot = std::min(static_cast<int>(left) - 1 + i, static_cast<int>(kNullKnots));
      if (knot > 0) sum += basis[static_cast<std::size_t>(i)] * wander_V_[knot - 1];
    }
    return sum;
  }

  WarmUp<N> warm_up_V_;
  N drift_V_{};
  const N* wander_V_ = nullptr;
  double knot_s_ = kLeastKnot_s;
  double tick_s_ = 0.0;
  double time_s_ = 0.0;
};

}  // namespace plenum::host::effects
