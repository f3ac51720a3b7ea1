// An O-ring piston pulled to and fro at 1, 3, 5 and 7 bar: means of the sliding samples, gathered by velocity
// in steps of 1 mm/s, of at least 50 samples; and the samples about one reversal of each record. A test holds
// both tables, and the numbers below them, to the records.
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

/// As the record has it.
struct PulledSample {
  double time_ms;
  double position_mm;
  double pressure_bar;  ///< gauge
  double force_N;
};

/// Every second sample within 0.6 s of the third turn at the far end of the stroke.
extern const std::array<std::vector<PulledSample>, 4> kMeasuredReversals;

/// What one F_c for each pressure leaves on all sliding samples, RMS, and how many they are.
inline constexpr double kRmsOfTheSamples_N = 0.589;
inline constexpr double kSlidingSamples = 29010;
/// No record keeps within 0.2 mm for longer.
inline constexpr double kLongestStay_s = 0.13;

}  // namespace plenum::host::reproduce::servo
