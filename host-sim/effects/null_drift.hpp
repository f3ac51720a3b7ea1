// null_drift: the valve's null moves during the run, as its coil warms or its supply pressure settles.
//
//   x = u - d(t),   d(t) = D (1 - e^(-t/tau)) / (1 - e^(-T/tau)) + sum_k A_k (1 - cos(pi k t/T))/2,  k = 1..5
//
// u command, x effective command [V]; D drift reached at T = 60 s [V]; tau time constant [s], infinite for a ramp; A_k
// waves that refine it where the null wanders [V]. Assumptions: both ports move together; t counts from the first row
// of a log. Vanishes at D = A_k = 0. Numerical treatment: held over a tick; the exponential is carried from tick to
// tick. Source: warm-up of proportional solenoids; the waves are the first terms of a Fourier series.
#pragma once

#include <array>
#include <numbers>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 7> kNullDriftParameters{{
    {"drift_at_60_s_V", "shift of the null after a minute", -1.5, 1.5, 0.0, 0.1},
    {"time_constant_s", "of its approach; infinite for a ramp", 2.0, kInfinity, kInfinity, 0.05,
     Coordinate::reciprocal},
    {"wave_1_V", "A_1, a period of 120 s", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wave_2_V", "A_2, 60 s", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wave_3_V", "A_3, 40 s", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wave_4_V", "A_4, 30 s", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
    {"wave_5_V", "A_5, 24 s", -1.5, 1.5, 0.0, 0.1, Coordinate::linear, true},
}};
inline constexpr Effect kNullDrift{"null_drift",
                                   Equation::command,
                                   "the command at which the valve is shut moves during the run",
                                   "x = u - D (1 - e^(-t/tau)) / (1 - e^(-60 s/tau)) - waves",
                                   "warm-up of proportional solenoids",
                                   kNullDriftParameters};

template <class N>
class NullDrift {
 public:
  void prepare(const N* x, double tick_s) {
    rate_V_ = each(x[1], [&](double per_s) {
      return per_s * kReference_s < 1e-9 ? tick_s / kReference_s
                                         : std::expm1(-tick_s * per_s) / std::expm1(-kReference_s * per_s);
    });
    rate_V_ = rate_V_ * x[0];
    fade_ = each(x[1], [&](double per_s) { return std::exp(-tick_s * per_s); });
    warm_up_V_ = N(0.0);
    drift_V_ = N(0.0);
    wave_V_ = x + 2;
    tick_s_ = tick_s;
    time_s_ = 0.0;
  }
  N at(const N& command) const { return command - drift_V_; }
  void end_tick() {
    warm_up_V_ += rate_V_;
    rate_V_ *= fade_;
    time_s_ += tick_s_;
    drift_V_ = warm_up_V_;
    for (int k = 1; k <= kWaves; ++k) {
      drift_V_ += wave_V_[k - 1] * (0.5 - 0.5 * std::cos(std::numbers::pi * k * time_s_ / kReference_s));
    }
  }

 private:
  static constexpr double kReference_s = 60.0;
  static constexpr int kWaves = 5;
  N drift_V_{}, warm_up_V_{}, rate_V_{}, fade_{};
  const N* wave_V_ = nullptr;
  double tick_s_ = 0.0;
  double time_s_ = 0.0;
};

}  // namespace plenum::host::effects
