// sensor_bias: the pressure sensor has an offset and a gain error, and its line may be bent.
//
//   z = p + O + g (p - P_a) + 4 b (p - P_a) (P_c - p) / (P_c - P_a)
//         + D (1 - e^(-t/tau)) / (1 - e^(-T/tau)) + k (u - u_0) + l |u - u_0|
//
// p pressure, z reading [Pa]; O offset [Pa]; g relative gain error [-], about ambient; b non-linearity: how far the reading is off the
// line through ambient and supply in the middle between them, of that span [-]; D drift reached at T = 60 s [Pa], tau its time
// constant [s], infinite for a ramp: a sensor that warms up; k and l what a volt of the command shifts the sensor's
// ground by [Pa/V], u_0 the valve's null: a current that both share, of a coil driven both ways, or of one for each way. Assumptions: t counts from the first row of a log; the current follows the
// command at once. Vanishes at O = g = D = k = l = b = 0. Numerical treatment: held over a tick; the exponential is carried from tick to
// tick. Source: transducer data sheets (zero and span error, non-linearity, warm-up); Morrison, Grounding and Shielding (2016).
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"
#include "host-sim/effects/warm_up.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 7> kSensorBiasParameters{{
    {"offset_kPa", "reading at ambient less ambient", -100.0, 100.0, 0.0, 1.0},
    {"gain_error", "relative, of the pressure above ambient", -0.3, 0.3, 0.0, 0.005},
    {"drift_at_60_s_kPa", "D: what the offset has drifted by after a minute", -100.0, 100.0, 0.0, 1.0,
     Coordinate::linear, true},
    {"drift_s", "tau: time constant of that; infinite for a ramp", 2.0, kInfinity, kInfinity, 0.05,
     Coordinate::reciprocal, true},
    {"ground_kPa_V", "k: offset for each volt of the command", -50.0, 50.0, 0.0, 0.3, Coordinate::linear,
     true},
    {"ground_even_kPa_V", "l: offset for each volt of the command off the null, either way", -50.0, 50.0, 0.0,
     0.3, Coordinate::linear, true},
    {"non_linearity", "b: off the line, half way from ambient to supply, of that span", -0.1, 0.1, 0.0, 0.003,
     Coordinate::linear, true},
}};
inline constexpr Effect kSensorBias{"sensor_bias",
                                    Equation::sensor,
                                    "the pressure reading has an offset, which may drift or follow the "
                                    "valve's current, a gain error, and a bend",
                                    "z = p + O + g (p - P_a) + 4 b (p - P_a) (P_c - p) / (P_c - P_a) + D (1 "
                                    "- e^(-t/tau)) / (1 - e^(-60 s/tau)) + k (u - u_0) + l |u - u_0|",
                                    "zero and span error and non-linearity of a transducer",
                                    kSensorBiasParameters};

template <class N>
class SensorBias {
 public:
  /// `x`: O, g, D, 1/tau, k, l, b; `null_V`: of the valve.
  void prepare(const N* x, double ambient_Pa, double supply_Pa, double tick_s, double command_V,
               const N& null_V) {
    offset_Pa_ = x[0] * 1e3;
    gain_ = x[1];
    ambient_Pa_ = ambient_Pa;
    supply_Pa_ = supply_Pa;
    bend_per_Pa_ = x[6] * (4.0 / (supply_Pa - ambient_Pa));
    warm_up_Pa_.prepare(x[2] * 1e3, x[3], tick_s);
    ground_Pa_V_ = x[4] * 1e3;
    even_Pa_V_ = x[5] * 1e3;
    null_V_ = null_V;
    shift(command_V);
  }
  /// A tick with this command: what is read at its end.
  void tick(double command_V) {
    shift(command_V);
    warm_up_Pa_.end_tick();
  }
  N reading(const N& pressure_Pa) const {
    return pressure_Pa + offset_Pa_ + warm_up_Pa_.drift() + shift_Pa_ +
           (gain_ + bend_per_Pa_ * (supply_Pa_ - pressure_Pa)) * (pressure_Pa - ambient_Pa_);
  }

 private:
  void shift(double command_V) {
    const N off_V = command_V - null_V_;
    shift_Pa_ = ground_Pa_V_ * off_V + even_Pa_V_ * magnitude(off_V);
  }

  WarmUp<N> warm_up_Pa_;
  N offset_Pa_{}, gain_{}, ground_Pa_V_{}, even_Pa_V_{}, null_V_{}, shift_Pa_{}, bend_per_Pa_{};
  double ambient_Pa_ = 0.0, supply_Pa_ = 0.0;
};

}  // namespace plenum::host::effects
