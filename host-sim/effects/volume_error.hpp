// volume_error: the chamber is larger (or smaller) than its log says: dead volume of fittings and cap.
//
//   v = v_log + D
//
// v volume [m3]; D offset [m3]. Assumptions: constant; a relative error of the volume is, while the volume is at
// rest, exactly a change of both flow gains. Vanishes at D = 0. The chamber keeps at least a tenth of the logged
// volume. Source: dead volume of "Pneumatic actuators" (5).
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 1> kVolumeErrorParameters{{
    {"offset_mL", "true volume less the logged one", -5000.0, 5000.0, 0.0, 3.0, Coordinate::linear, false,
     kAsTheVolume},
}};
inline constexpr Effect kVolumeError{"volume_error",
                                     Equation::energy,
                                     "the chamber holds more or less air than its logged volume says",
                                     "v = v_log + D",
                                     "dead volume of hoses and caps",
                                     kVolumeErrorParameters};

template <class N>
class VolumeError {
 public:
  void prepare(const N* x) { offset_m3_ = x[0] * 1e-6; }
  N volume(double logged_m3) const { return larger(logged_m3 + offset_m3_, N(0.1 * logged_m3)); }

 private:
  N offset_m3_{};
};

}  // namespace plenum::host::effects
