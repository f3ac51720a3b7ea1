// sensor_lag: the pressure sensor, with its cavity and filter, answers late.
//
//   tau y' = p - y
//
// p pressure, y reading [Pa]; tau time constant [s]. Vanishes at tau = 0. Numerical treatment: exact for a pressure
// that changes linearly over a step; the mean of y over the step follows from the balance tau (y1 - y0) = int(p -
// y), to the last bit. Source: first-order transducer.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 1> kSensorLagParameters{{
    {"time_constant_s", "of the sensor with its cavity and filter", 0.0, 0.3, 0.0, 0.002},
}};
inline constexpr Effect kSensorLag{
    "sensor_lag",     Equation::sensor,         "the pressure reading follows the pressure late",
    "tau y' = p - y", "first-order transducer", kSensorLagParameters};

template <class N>
class SensorLag {
 public:
  void prepare(const N* x, double step_s, const N& start_Pa) {
    tau_per_step_ = x[0] * (1.0 / step_s);
    keep_ = each(x[0], [&](double tau) { return tau > 0.0 ? std::exp(-step_s / tau) : 0.0; });
    reading_Pa_ = start_Pa;
  }
  /// One step from `begin` to `end` with this mean; returns the mean of the reading.
  N follow(const N& begin_Pa, const N& end_Pa, const N& mean_Pa) {
    const N lag = tau_per_step_ * (end_Pa - begin_Pa);
    const N next = end_Pa - lag + (reading_Pa_ - begin_Pa + lag) * keep_;
    const N mean_reading = mean_Pa - tau_per_step_ * (next - reading_Pa_);
    reading_Pa_ = next;
    return mean_reading;
  }
  const N& reading_Pa() const { return reading_Pa_; }

 private:
  N tau_per_step_{}, keep_{}, reading_Pa_{};
};

}  // namespace plenum::host::effects
