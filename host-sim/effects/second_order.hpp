// How a damped mass on a spring comes to rest: what a step keeps of its distance from rest and of its speed.
//
//   (tau/(2 zeta))^2 e'' + tau e' + e = 0
//
// e distance from rest; tau [s] how late it follows a ramp; zeta damping ratio [-], infinite for a lag of the first
// order, e' = -e/tau. Numerical treatment: with g = tau e' and q = 1/(4 zeta^2), (e, g) is multiplied by the exponential
// of (h/tau) [[0, 1], [-1/q, -1/q]], by Sylvester's formula in the poles S/q and F/q, which stays finite at q = 0.
#pragma once

#include <complex>

#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

template <class N>
class SecondOrder {
 public:
  struct State {
    N off;    ///< e
    N speed;  ///< g = tau e', in the unit of e
  };

  /// `per_damping2`: 1/zeta^2; `step_s`: what one call of after_step() spans.
  void prepare(const N& tau_s, const N& per_damping2, double step_s) {
    for (int i = 0; i < kLanesOf<N>; ++i) {
      const double tau = lane(tau_s, i);
      const Kept kept = tau > 0.0 ? over(step_s / tau, lane(per_damping2, i)) : Kept{};
      set_lane(off_, i, kept.off);
      set_lane(off_by_speed_, i, kept.off_by_speed);
      set_lane(speed_by_off_, i, kept.speed_by_off);
      set_lane(speed_, i, kept.speed);
    }
    tau_per_step_ = tau_s * (1.0 / step_s);
    inertia_per_step_ = 0.25 * per_damping2 * tau_per_step_;
  }

  State after_step(const State& s) const {
    return {off_ * s.off + off_by_speed_ * s.speed, speed_by_off_ * s.off + speed_ * s.speed};
  }
  /// What the mean over a step, of whatever drives the mass, exceeds that of its place by, from the equation integrated.
  N late(const N& way, const N& gain_of_speed) const {
    return tau_per_step_ * way + inertia_per_step_ * gain_of_speed;
  }
  /// tau over the step.
  const N& tau_per_step() const { return tau_per_step_; }

 private:
  struct Kept {
    double off = 0.0, off_by_speed = 0.0, speed_by_off = 0.0, speed = 0.0;
  };
  static Kept over(double time_constants, double per_damping2) {
    // distinct poles, real or complex; near critical damping they are moved apart
    const double c = std::abs(per_damping2 - 1.0) < 1e-8 ? per_damping2 - 2e-8 : per_damping2;
    const std::complex<double> gap = std::sqrt(std::complex<double>(1.0 - c));
    const std::complex<double> fast = -0.5 * (1.0 + gap);
    const std::complex<double> slow = -0.5 * c / (1.0 + gap);
    const std::complex<double> slowly = std::exp(-2.0 * time_constants / (1.0 + gap));
    const std::complex<double> fastly =
        c > 0.0 ? std::exp(-2.0 * time_constants / c * (1.0 + gap)) : std::complex<double>();
    const double turn = ((slowly - fastly) / gap).real();
    return {((slow * fastly - fast * slowly) / gap).real(), 0.25 * c * turn, -turn,
            (((1.0 + slow) * fastly - (1.0 + fast) * slowly) / gap).real()};
  }

  N off_{}, off_by_speed_{}, speed_by_off_{}, speed_{}, tau_per_step_{}, inertia_per_step_{};
};

}  // namespace plenum::host::effects
