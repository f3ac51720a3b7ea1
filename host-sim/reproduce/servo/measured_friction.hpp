// An O-ring piston pulled to and fro at 1, 3, 5 and 7 bar: means of the sliding samples, gathered by velocity
// in steps of 1 mm/s, of at least 50 samples. A test holds the table to the records.
// Source: EvaZillen/3D-printed-pneumatic-actuator, results_pneumatic-actuator/data/friction, CC0-1.0; whole
// in tests/data/friction_zillen.
#pragma once

#include <array>
#include <vector>

namespace plenum::host::reproduce::servo {

struct PulledMean {
  double velocity_m_s;
  double pressure_Pa;  ///< gauge
  double force_N;
  double samples;
};

inline constexpr std::array<int, 4> kPulledAt_bar{1, 3, 5, 7};
extern const std::array<std::vector<PulledMean>, 4> kMeasuredFriction;

}  // namespace plenum::host::reproduce::servo
