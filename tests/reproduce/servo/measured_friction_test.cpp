#include "host-sim/reproduce/servo/measured_friction.hpp"

#include <gtest/gtest.h>

#include "tests/identify/servo/pulled_records.hpp"

namespace plenum::host::reproduce::servo {
namespace {

TEST(MeasuredFrictionTable, FollowsFromTheRecords) {
  const auto records = identify::servo::pulled_rows();
  for (std::size_t r = 0; r < records.size(); ++r) {
    const auto means = identify::servo::gathered(records[r], 1e-3, 50);
    ASSERT_EQ(kMeasuredFriction[r].size(), means.size()) << "record " << r;
    for (std::size_t i = 0; i < means.size(); ++i) {
      const PulledMean& row = kMeasuredFriction[r][i];
      EXPECT_NEAR(row.velocity_m_s, means[i].velocity_m_s, 0.5e-5 + 1e-9);
      EXPECT_NEAR(row.pressure_Pa, means[i].pressure_Pa, 0.5 + 1e-6);
      EXPECT_NEAR(row.force_N, means[i].force_N, 0.5e-3 + 1e-9);
      EXPECT_EQ(row.samples, means[i].weight);
    }
  }
}

TEST(MeasuredFrictionTable, GivesTheCoulombFrictionOfTheSamples) {
  const auto samples = identify::servo::fit_friction(identify::servo::pulled_rows(), {false, {}});
  std::vector<std::vector<identify::servo::SlidingRow>> table;
  for (const auto& record : kMeasuredFriction) {
    table.emplace_back();
    for (const PulledMean& mean : record)
      table.back().push_back({0.0, 0.0, mean.velocity_m_s, mean.pressure_Pa, mean.force_N, mean.samples});
  }
  const auto means = identify::servo::fit_friction(table, {false, {}});
  for (std::size_t r = 0; r < 4; ++r)
    EXPECT_NEAR(means.coulomb_N[r], samples.coulomb_N[r], 0.1) << "record " << r;
}

}  // namespace
}  // namespace plenum::host::reproduce::servo
