#include "host-sim/identify/regulator_valve/branch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

using plant::regulator_valve::Recording;
using testing::HasSubstr;
using testing::ThrowsMessage;

// A staircase that settles at once: rising p = g (x - band), falling p = g x, and in between it stays.
Recording ideal(double slope_Pa_m, double dead_band_m) {
  Recording r{.sample_s = 0.005, .screw_m = {}, .pressure_Pa = {}};
  double p = 0.0;
  for (const auto& hold : plant::regulator_valve::staircase(0.25e-3, 13, 1.0)) {
    p = std::max(slope_Pa_m * (hold.screw_m - dead_band_m), std::min(p, slope_Pa_m * hold.screw_m));
    r.screw_m.insert(r.screw_m.end(), 200, hold.screw_m);
    r.pressure_Pa.insert(r.pressure_Pa.end(), 200, p);
  }
  return r;
}

TEST(RegulatorValveBranch, MeasuresTheDeadBandThatIsThere) {
  for (const double band_m : {0.0, 0.3e-3, 0.9e-3}) {
    const DeadBand found = measure_dead_band(ideal(1.56e8, band_m));
    EXPECT_NEAR(found.width_m, band_m, 1e-12);
    EXPECT_NEAR(found.rising_start_m, band_m, 1e-12);
    EXPECT_NEAR(found.rising_slope_Pa_m, 1.56e8, 1.0);
    EXPECT_NEAR(found.falling_slope_Pa_m, 1.56e8, 1.0);
  }
}

TEST(RegulatorValveBranch, PlateausAreThePositionsHeld) {
  const auto found = plateaus(ideal(1.56e8, 0.9e-3));
  ASSERT_EQ(found.size(), 27U);
  EXPECT_EQ(found[5].first, 1000U);
  EXPECT_EQ(found[5].end, 1200U);
  EXPECT_EQ(found[5].screw_m, 1.25e-3);
  EXPECT_NEAR(found[5].settled_Pa, 1.56e8 * 0.35e-3, 1e-6);
}

TEST(RegulatorValveBranch, HoldsOneDirectionWithinTheRangeAndHasZeroMean) {
  const Recording recording = ideal(1.56e8, 0.9e-3);
  for (const Direction direction : {Direction::kRising, Direction::kFalling}) {
    const Branch branch = branch_of(recording, direction);
    EXPECT_NEAR(std::accumulate(branch.pressure_Pa.begin(), branch.pressure_Pa.end(), 0.0), 0.0, 1e-3);
    EXPECT_NEAR(std::accumulate(branch.screw_m.begin(), branch.screw_m.end(), 0.0), 0.0, 1e-12);
    for (std::size_t k = 0; k < branch.screw_m.size(); ++k) {
      const double p = branch.pressure_Pa[k] + branch.mean_pressure_Pa;
      EXPECT_GE(p, 0.894e5);
      EXPECT_LE(p, 3.224e5);
      EXPECT_EQ(recording.pressure_Pa[branch.first + k], p);
      if (k > 0) {
        EXPECT_EQ(branch.screw_m[k] >= branch.screw_m[k - 1],
                  direction == Direction::kRising || branch.screw_m[k] == branch.screw_m[k - 1]);
      }
    }
    EXPECT_EQ(branch.screw_m[19], branch.screw_m[0]);  // 0.1 s of rest, then the first turn
    EXPECT_NE(branch.screw_m[20], branch.screw_m[0]);
  }
}

TEST(RegulatorValveBranch, SaysThatNothingLiesInTheRange) {
  EXPECT_THAT([] { branch_of(ideal(1.56e8, 0.9e-3), Direction::kFalling, {.low_Pa = 1e6, .high_Pa = 2e6}); },
              ThrowsMessage<CannotIdentify>(HasSubstr("falling branch: 0 plateaus")));
}

TEST(RegulatorValveBranch, RefusesARecordingOfUnequalLengths) {
  Recording recording = ideal(1.56e8, 0.9e-3);
  recording.pressure_Pa.pop_back();
  EXPECT_THROW(plateaus(recording), std::invalid_argument);
  EXPECT_THROW(zero_mean(recording, 5, 5), std::invalid_argument);
}

TEST(RegulatorValveBranch, RefusesASampleTimeNotAboveZero) {
  Recording recording = ideal(1.56e8, 0.9e-3);
  for (const double sample_s : {0.0, -0.005, std::numeric_limits<double>::quiet_NaN()}) {
    recording.sample_s = sample_s;
    EXPECT_THAT([&] { branch_of(recording, Direction::kRising); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("sample_s")));
  }
}

}  // namespace
}  // namespace plenum::host::identify::regulator_valve
