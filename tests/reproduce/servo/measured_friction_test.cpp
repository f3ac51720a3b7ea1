#include "host-sim/reproduce/servo/measured_friction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host-sim/reproduce/servo/driven_friction.hpp"
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

TEST(MeasuredReversals, AreSamplesOfTheRecords) {
  for (std::size_t r = 0; r < 4; ++r) {
    const auto record = identify::servo::pulled_record(kPulledAt_bar[r]);
    const auto& samples = kMeasuredReversals[r];
    const auto first =
        std::lower_bound(record.time_s.begin(), record.time_s.end(), 1e-3 * samples.front().time_ms - 1e-6);
    auto row = static_cast<std::size_t>(first - record.time_s.begin());
    for (const PulledSample& sample : samples) {
      ASSERT_LT(row, record.time_s.size());
      EXPECT_NEAR(1e-3 * sample.time_ms, record.time_s[row], 1e-9);
      EXPECT_NEAR(1e-3 * sample.position_mm, record.position_m[row], 1e-12);
      EXPECT_NEAR(1e5 * sample.pressure_bar, record.pressure_Pa[row], 1e-6);
      EXPECT_EQ(sample.force_N, record.force_N[row]);
      row += 2;
    }
  }
}

TEST(MeasuredReversals, TurnOnceInTheMiddle) {
  for (const auto& samples : kMeasuredReversals) {
    const auto turn = std::max_element(
        samples.begin(), samples.end(),
        [](const PulledSample& a, const PulledSample& b) { return a.position_mm < b.position_mm; });
    EXPECT_NEAR(turn->time_ms, 0.5 * (samples.front().time_ms + samples.back().time_ms), 50.0);
    EXPECT_GT(turn->position_mm, samples.front().position_mm + 2.0);
    EXPECT_GT(turn->position_mm, samples.back().position_mm + 2.0);
  }
}

TEST(MeasuredFrictionTable, ErrorAndCountOfTheSamplesAreTheRecords) {
  const auto records = identify::servo::pulled_rows();
  double count = 0.0;
  for (const auto& record : records) count += static_cast<double>(record.size());
  EXPECT_EQ(kSlidingSamples, count);
  EXPECT_NEAR(kRmsOfTheSamples_N, identify::servo::fit_friction(records, {false, {}}).rms_N, 0.5e-3);
}

TEST(MeasuredFrictionTable, NoRecordRestsLongerThanItSays) {
  double longest_s = 0.0;
  for (const int bar : kPulledAt_bar) {
    const auto record = identify::servo::pulled_record(bar);
    for (std::size_t first = 0, last = 0; last < record.time_s.size(); ++last) {
      const auto within = [&] {
        const auto [least, most] =
            std::minmax_element(record.position_m.begin() + static_cast<std::ptrdiff_t>(first),
                                record.position_m.begin() + static_cast<std::ptrdiff_t>(last) + 1);
        return *most - *least <= 0.2e-3;
      };
      while (!within()) ++first;
      longest_s = std::max(longest_s, record.time_s[last] - record.time_s[first]);
    }
  }
  EXPECT_NEAR(longest_s, kLongestStay_s, 5e-3);
}

// A piston on a straight path that turns at once: friction is F_c one way, then the other.
TEST(DrivenFriction, FollowsCoulombWhereTheMotionIsCoulombs) {
  std::vector<PulledSample> samples;
  for (int i = 0; i <= 100; ++i) {
    const double t_ms = 20.0 * i;
    const double x_mm = 10.0 - 10e-3 * std::abs(t_ms - 1000.0);
    samples.push_back({t_ms, x_mm, 2.0, 5e-4 * 2e5 + 0.5 + (t_ms < 1000.0 ? 6.0 : -6.0)});
  }
  plant::servo::Friction coulomb;
  coulomb.coulomb_N = 6.0;
  const DrivenFriction driven = driven_friction(samples, {.area_m2 = 5e-4, .zero_N = 0.5}, coulomb);
  EXPECT_NEAR(driven.span_N(), 12.0, 1e-9);
  for (std::size_t i = 0; i < driven.time_s.size(); ++i) {
    if (std::abs(driven.time_s[i] - 1.0) < 0.021) continue;  // where the plant's piston sticks and turns
    EXPECT_NEAR(driven.plant_N[i], driven.measured_N[i], 1e-9) << driven.time_s[i] << " s";
  }
  EXPECT_GT(driven.stuck_s, 0.0);
  // the coupling lets go of 2 F_c = 12 N over 12 um, at 0.1 m/s2 of the smoothed turn: sqrt(2 12 um / 0.1) = 15 ms
  EXPECT_NEAR(driven.stuck_s, 0.0155, 0.005);
}

}  // namespace
}  // namespace plenum::host::reproduce::servo
