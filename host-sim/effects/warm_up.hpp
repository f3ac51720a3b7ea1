// What drifts as something warms up: a share of the way, which is 1 after a minute.
//
//   (1 - e^(-t/tau)) / (1 - e^(-T/tau)),   T = 60 s;   t/T for an infinite tau
//
// t time since the first row of a log, tau time constant, T reference [s]. Carried from tick to tick. Shared by null_drift and
// sensor_bias. Source: first-order thermal response; Doebelin, Measurement Systems, 3.
#pragma once

#include <cmath>

#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr double kWarmUpReference_s = 60.0;  ///< T

template <class N>
class WarmUp {
 public:
  /// `reach`: what it comes to at T, in whatever unit; `per_s`: 1/tau.
  void prepare(const N& reach, const N& per_s, double tick_s) {
    rate_ = each(per_s, [&](double each_per_s) {
      return each_per_s * kWarmUpReference_s < 1e-9
                 ? tick_s / kWarmUpReference_s
                 : std::expm1(-tick_s * each_per_s) / std::expm1(-kWarmUpReference_s * each_per_s);
    });
    rate_ *= reach;
    fade_ = each(per_s, [&](double each_per_s) { return std::exp(-tick_s * each_per_s); });
    drift_ = N(0.0);
  }
  void end_tick() {
    drift_ += rate_;
    rate_ *= fade_;
  }
  const N& drift() const { return drift_; }

 private:
  N drift_{}, rate_{}, fade_{};
};

}  // namespace plenum::host::effects
