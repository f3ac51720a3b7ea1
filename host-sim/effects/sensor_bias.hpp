// sensor_bias: the pressure sensor has an offset and a gain error.
//
//   z = p + O + g (p - P_a)
//
// p pressure, z reading [Pa]; O offset [Pa]; g relative gain error [-], about ambient. Vanishes at O = g = 0.
// Source: transducer data sheets (zero and span error).
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kSensorBiasParameters{{
    {"offset_kPa", "reading at ambient less ambient", -100.0, 100.0, 0.0, 1.0},
    {"gain_error", "relative, of the pressure above ambient", -0.3, 0.3, 0.0, 0.005},
}};
inline constexpr Effect kSensorBias{"sensor_bias",
                                    Equation::sensor,
                                    "the pressure reading has an offset and a gain error",
                                    "z = p + O + g (p - P_a)",
                                    "zero and span error of a transducer",
                                    kSensorBiasParameters};

template <class N>
class SensorBias {
 public:
  void prepare(const N* x, double ambient_Pa) {
    offset_Pa_ = x[0] * 1e3;
    gain_ = x[1];
    ambient_Pa_ = ambient_Pa;
  }
  N reading(const N& pressure_Pa) const {
    return pressure_Pa + offset_Pa_ + gain_ * (pressure_Pa - ambient_Pa_);
  }

 private:
  N offset_Pa_{}, gain_{};
  double ambient_Pa_ = 0.0;
};

}  // namespace plenum::host::effects
