#include "host-sim/reproduce/actuators/study.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plenum::host::reproduce::actuators {
namespace {

identify::Drift drift_of(double mean_percent, double std_percent) {
  return {{0.01}, {std_percent}, {mean_percent}, std_percent};
}

Identified chamber_of(double mean_percent, double std_percent) {
  const identify::Drift drift = drift_of(mean_percent, std_percent);
  return {{{}, plant::VolumeMotion(1e-4)}, {}, {}, {}, drift, drift};
}

TEST(Population, TruthIsThatOfTheRecord) {
  for (const Motion motion : {Motion::rest, Motion::moderate, Motion::violent}) {
    const PopulationChamber truth = chamber_of_seed(5, motion);
    const trace::Log log = record_chamber(5, motion, 50);
    for (std::size_t k = 0; k < log.size(); ++k) {
      EXPECT_NEAR(log.volume_m3[k], truth.volume.at(log.time_s[k]).volume_m3, 1e-15);
    }
  }
  EXPECT_EQ(chamber_of_seed(5, Motion::moderate).volume.mean_m3(),
            chamber_of_seed(5, Motion::rest).volume.mean_m3());
}

TEST(Population, ViolentVolumeDoubles) {
  for (unsigned seed = 1; seed <= kPopulation; ++seed) {
    const PopulationChamber drawn = chamber_of_seed(seed, Motion::violent);
    const plant::VolumeMotion& volume = drawn.volume;
    double smallest_m3 = volume.mean_m3();
    double largest_m3 = volume.mean_m3();
    double fastest_m3_s = 0.0;
    for (double time_s = 0.0; time_s < 2.5; time_s += 1e-3) {  // a period of the slowest
      const plant::VolumeState at = volume.at(time_s);
      smallest_m3 = std::min(smallest_m3, at.volume_m3);
      largest_m3 = std::max(largest_m3, at.volume_m3);
      fastest_m3_s = std::max(fastest_m3_s, std::abs(at.rate_m3_s));
    }
    EXPECT_NEAR(largest_m3 / smallest_m3, 2.0, 0.11) << "seed " << seed;
    EXPECT_LT(fastest_m3_s, std::numbers::pi * 1.6 * (largest_m3 - smallest_m3) * 1.001) << "seed " << seed;
  }
}

TEST(Study, PooledDriftOfOneChamberIsItsOwn) {
  EXPECT_NEAR(pooled_drift_percent({chamber_of(1.0, 3.0)}, &Identified::one_step_drift).front(), 3.0, 1e-12);
}

TEST(Study, PooledDriftSeesChambersThatDriftApart) {
  // two chambers of 48 runs each, no scatter within: all errors are +2 or -2
  const double pooled =
      pooled_drift_percent({chamber_of(2.0, 0.0), chamber_of(-2.0, 0.0)}, &Identified::one_step_drift)
          .front();
  EXPECT_NEAR(pooled, std::sqrt(96.0 * 4.0 / 95.0), 1e-12);
}

TEST(Study, TypicalChamberIsTheOneOfMedianDrift) {
  EXPECT_EQ(place_of_typical({chamber_of(0.0, 9.0), chamber_of(0.0, 2.0), chamber_of(0.0, 5.0)}), 2U);
}

TEST(Study, LateGrowthIsThatOfTheSecondHalf) {
  EXPECT_EQ(late_growth_percent({{}, {1.0, 2.0, 4.0, 7.0}, {}, 7.0}), 3.0);
}

}  // namespace
}  // namespace plenum::host::reproduce::actuators
