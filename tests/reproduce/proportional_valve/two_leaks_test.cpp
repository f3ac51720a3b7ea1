#include "host-sim/reproduce/proportional_valve/two_leaks.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host-sim/reproduce/proportional_valve/experiment.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using identify::orifice::Flow;

TEST(TwoLeaks, RestWhereTheirFlowsAreEqualFromBothSides) {
  const TwoLeaks leaks = leaks_resting_at(5.25e5, 0.15);
  EXPECT_NEAR(net_rate_Pa_s(leaks, 5.25e5), 0.0, 1e-6);
  EXPECT_NEAR(run_of(leaks, Flow::kCharge, 60.0).vessel_Pa.back(), 5.25e5, 10.0);
  EXPECT_NEAR(run_of(leaks, Flow::kDischarge, 60.0).vessel_Pa.back(), 5.25e5, 10.0);
}

// By hand: r = 0.75, xi = 0.222/0.472, psi/psi_max = sqrt(1 - xi^2) = 0.88248; the way out is choked.
TEST(TwoLeaks, AreSizedByTheirBalance) {
  const TwoLeaks leaks = leaks_resting_at(0.75 * kSupply_Pa, 0.15);
  EXPECT_NEAR(leaks.out_1_s, 0.15 * 0.88248 / 0.75, 1e-5);
}

// Both choked from 1.9 to 3.7 bar: pdot = k_in P_s - k_out p.
TEST(TwoLeaks, FollowTheExponentialWhileBothAreChoked) {
  const TwoLeaks leaks = leaks_resting_at(5.25e5, 0.15);
  const identify::orifice::VesselRecord record = run_of(leaks, Flow::kCharge, 10.0);
  const double target_Pa = leaks.in_1_s / leaks.out_1_s * kSupply_Pa;
  std::size_t first = 0;
  while (record.vessel_Pa[first] < 1.95e5) ++first;
  std::size_t last = first;
  while (record.vessel_Pa[last] < 3.65e5) ++last;
  const double t = record.time_s[last] - record.time_s[first];
  EXPECT_NEAR(record.vessel_Pa[last],
              target_Pa + (record.vessel_Pa[first] - target_Pa) * std::exp(-leaks.out_1_s * t), 0.1);
}

}  // namespace
}  // namespace plenum::host::reproduce::proportional_valve
