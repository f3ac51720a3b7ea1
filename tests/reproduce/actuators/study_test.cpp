#include "host-sim/reproduce/actuators/study.hpp"

#include <gtest/gtest.h>

#include <cmath>

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
  for (const bool moves : {false, true}) {
    const PopulationChamber truth = chamber_of_seed(5, moves);
    const trace::Log log = record_chamber(5, moves, 50);
    for (std::size_t k = 0; k < log.size(); ++k) {
      EXPECT_NEAR(log.volume_m3[k], truth.volume.at(log.time_s[k]).volume_m3, 1e-15);
    }
  }
  EXPECT_EQ(chamber_of_seed(5, true).volume.mean_m3(), chamber_of_seed(5, false).volume.mean_m3());
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
