// null_drift: the valve's null moves during the run, as its coil warms or its supply pressure settles.
//
//   x = u - d(t),   d(t) = D (1 - e^(-t/tau)) / (1 - e^(-T/tau))
//
// u command, x effective command [V]; D drift reached at T = 60 s [V]; tau time constant [s], infinite for a ramp.
// Assumptions: both ports move together; t counts from the first row of a log. Vanishes at D = 0. Numerical
// treatment: the exponential is carried from tick to tick. Source: warm-up of proportional solenoids.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kNullDriftParameters{{
    {"drift_at_60_s_V", "shift of the null after a minute", -1.5, 1.5, 0.0, 0.02},
    {"time_constant_s", "of its approach; infinite for a ramp", 2.0, kInfinity, kInfinity, 0.05,
     Coordinate::reciprocal},
}};
inline constexpr Effect kNullDrift{"null_drift",
                                   Equation::command,
                                   "the command at which the valve is shut moves during the run",
                                   "x = u - D (1 - e^(-t/tau)) / (1 - e^(-60 s/tau))",
                                   "warm-up of proportional solenoids",
                                   kNullDriftParameters};

template <class N>
class NullDrift {
 public:
  void prepare(const N* x, double tick_s) {
    constexpr double kReference_s = 60.0;
    rate_V_ = each(x[1], [&](double per_s) {
      return per_s * kReference_s < 1e-9 ? tick_s / kReference_s
                                         : std::expm1(-tick_s * per_s) / std::expm1(-kReference_s * per_s);
    });
    rate_V_ = rate_V_ * x[0];
    fade_ = each(x[1], [&](double per_s) { return std::exp(-tick_s * per_s); });
    drift_V_ = N(0.0);
  }
  N at(const N& command) const { return command - drift_V_; }
  void end_tick() {
    drift_V_ += rate_V_;
    rate_V_ *= fade_;
  }

 private:
  N drift_V_{}, rate_V_{}, fade_{};
};

}  // namespace plenum::host::effects
