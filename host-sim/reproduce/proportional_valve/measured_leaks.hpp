// Two printed vessels that leak down from 7.5 bar, measured at 10 Hz; every tenth row from where the leak has
// taken 3 %. Volume and atmosphere were not recorded.
// Source: EvaZillen/3D-printed-pneumatic-actuator, appendix_compressed-air_chamber/data, CC0-1.0; whole in
// tests/data/leak_zillen.
#pragma once

#include <vector>

namespace plenum::host::reproduce::proportional_valve {

struct LeakSample {
  double time_s;
  double gauge_bar;
};

extern const std::vector<LeakSample> kSlowLeak;
extern const std::vector<LeakSample> kFastLeak;

}  // namespace plenum::host::reproduce::proportional_valve
