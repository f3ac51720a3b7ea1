// sensor_lag: the pressure sensor, with its cavity and filter, answers late.
//
//   (tau/(2 zeta))^2 y'' + tau y' = p - y
//
// p pressure, y reading [Pa]; tau time constant [s], by which a ramp is read late; zeta damping [-] of the air in the cavity
// and its passage, infinite where that has no inertia. Vanishes at tau = 0; at zeta -> infinity it is of the first order.
// Numerical treatment: exact for a pressure that changes linearly over a step (second_order.hpp); the mean of y over the
// step follows from the balance tau (y1 - y0) + (tau/(2 zeta))^2 (y1' - y0') = int(p - y), to the last bit. Source:
// Doebelin, Measurement Systems, 6: transducers of the first order, and with the volume and tubing before them.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"
#include "host-sim/effects/second_order.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kSensorLagParameters{{
    {"time_constant_s", "of the sensor with its cavity and filter", 0.0, 0.3, 0.0, 0.002},
    {"damping", "zeta: damping ratio of its second order", 0.5, kInfinity, kInfinity, 0.3,
     Coordinate::reciprocal_square, true},
}};
inline constexpr Effect kSensorLag{"sensor_lag",
                                   Equation::sensor,
                                   "the pressure reading follows the pressure late",
                                   "(tau/(2 zeta))^2 y'' + tau y' = p - y",
                                   "first-order transducer; with a cavity: Doebelin, Measurement Systems",
                                   kSensorLagParameters};

template <class N>
class SensorLag {
 public:
  /// `x`: tau and 1/zeta^2; `step_s`: what one call of follow() spans.
  void prepare(const N* x, double step_s, const N& start_Pa) {
    lag_.prepare(x[0], x[1], step_s);
    reading_Pa_ = start_Pa;
    rise_Pa_ = N(0.0);
  }
  /// One step from `begin` to `end` with this mean; returns the mean of the reading.
  N follow(const N& begin_Pa, const N& end_Pa, const N& mean_Pa) {
    const N late = lag_.tau_per_step() * (end_Pa - begin_Pa);
    const auto left = lag_.after_step({reading_Pa_ - begin_Pa + late, rise_Pa_ - late});
    const N next = end_Pa - late + left.off;
    const N next_rise = late + left.speed;
    const N mean_reading = mean_Pa - lag_.late(next - reading_Pa_, next_rise - rise_Pa_);
    reading_Pa_ = next;
    rise_Pa_ = next_rise;
    return mean_reading;
  }
  const N& reading_Pa() const { return reading_Pa_; }

 private:
  SecondOrder<N> lag_;
  N reading_Pa_{}, rise_Pa_{};  ///< y and tau y'
};

}  // namespace plenum::host::effects
