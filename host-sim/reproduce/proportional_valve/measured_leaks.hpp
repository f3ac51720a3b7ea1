// Vessels that leak down from 7.5 bar, measured at 10 Hz; every tenth row, of those that leak out from where the leak has
// taken 3 %. Volume and atmosphere were not recorded.
// Source: EvaZillen/3D-printed-pneumatic-actuator, appendix_compressed-air_chamber/data, CC0-1.0; whole in
// tests/data/leak_zillen.
#pragma once

#include <array>
#include <vector>

namespace plenum::host::reproduce::proportional_valve {

struct LeakSample {
  double time_s;
  double gauge_bar;
};
struct MeasuredLeak {
  const char* vessel;
  std::vector<LeakSample> samples;
};
extern const std::vector<MeasuredLeak> kMeasuredLeaks;  ///< the fastest first

/// A row of three tests of one leak: the change since their first rows.
struct RepeatedSample {
  double time_s;
  std::array<double, 3> change_mbar;
};
/// Ultimaker_006, taken off and connected again before each test.
extern const std::vector<RepeatedSample> kReconnected;
/// Where the first test began, which is the record of Ultimaker_006; of the others that was not recorded, and they are taken to
/// have begun there too.
inline constexpr double kReconnectedFrom_gauge_bar = 7.825;

}  // namespace plenum::host::reproduce::proportional_valve
