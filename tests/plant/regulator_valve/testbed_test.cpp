#include "host-sim/plant/regulator_valve/testbed.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace plenum::host::plant::regulator_valve {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

const std::vector<Hold> kTwoSteps{{1e-3, 0.5}, {1.25e-3, 1.0}};

TEST(RegulatorValveTestbed, RecordsTheScrewAsCommandedAndNotAsTurned) {
  const Recording r = record(bench_valve(), {}, 1e5, kTwoSteps);
  ASSERT_EQ(r.screw_m.size(), 300U);
  ASSERT_EQ(r.pressure_Pa.size(), 300U);
  EXPECT_EQ(r.screw_m[99], 1e-3);
  EXPECT_EQ(r.screw_m[100], 1.25e-3);
}

TEST(RegulatorValveTestbed, TheSameSeedIsTheSameRecordingAndAnotherIsNot) {
  const Recording first = record(bench_valve(), {.seed = 7}, 1e5, kTwoSteps);
  EXPECT_EQ(first.pressure_Pa, record(bench_valve(), {.seed = 7}, 1e5, kTwoSteps).pressure_Pa);
  EXPECT_NE(first.pressure_Pa, record(bench_valve(), {.seed = 8}, 1e5, kTwoSteps).pressure_Pa);
}

TEST(RegulatorValveTestbed, NoiseIsAddedToTheReadingAndNotToThePlant) {
  const Recording quiet = record(bench_valve(), {.noise_Pa = 0.0}, 1e5, kTwoSteps);
  const Recording noisy = record(bench_valve(), {.noise_Pa = 500.0}, 1e5, kTwoSteps);
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t k = 0; k < quiet.pressure_Pa.size(); ++k) {
    const double e = noisy.pressure_Pa[k] - quiet.pressure_Pa[k];
    sum += e;
    squares += e * e;
  }
  const double n = static_cast<double>(quiet.pressure_Pa.size());
  EXPECT_NEAR(sum / n, 0.0, 4.0 * 500.0 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 500.0, 4.0 * 500.0 / std::sqrt(2.0 * n));
}

TEST(RegulatorValveTestbed, ASlowerHandIsLaterByHalfItsTurn) {
  const auto settled_area = [](double turn_s) {  // integral of what is left to go
    const Recording r = record(bench_valve(), {.turn_s = turn_s, .noise_Pa = 0.0}, 1.156e5, kTwoSteps);
    double sum = 0.0;
    for (std::size_t k = 100; k < r.pressure_Pa.size(); ++k) sum += r.pressure_Pa.back() - r.pressure_Pa[k];
    return 0.005 * sum / (r.pressure_Pa.back() - r.pressure_Pa[100]);
  };
  EXPECT_NEAR(settled_area(0.3) - settled_area(0.1), 0.1, 0.002);
}

TEST(RegulatorValveTestbed, TheStaircaseGoesUpAndDownAgain) {
  const std::vector<Hold> holds = staircase(0.25e-3, 3, 2.0);
  ASSERT_EQ(holds.size(), 7U);
  EXPECT_EQ(holds.front().screw_m, 0.0);
  EXPECT_EQ(holds[3].screw_m, 0.75e-3);
  EXPECT_EQ(holds[4].screw_m, 0.5e-3);
  EXPECT_EQ(holds.back().screw_m, 0.0);
}

TEST(RegulatorValveTestbed, RefusesABenchThatCannotBe) {
  EXPECT_THAT([] { record(bench_valve(), {.sample_s = 0.0}, 1e5, kTwoSteps); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("sample_s")));
  EXPECT_THAT([] { record(bench_valve(), {.noise_Pa = -1.0}, 1e5, kTwoSteps); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("noise_Pa")));
  EXPECT_THAT([] { record(bench_valve(), {}, 1e5, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("holds")));
  EXPECT_THAT(
      [] {
        record(bench_valve(), {}, 1e5, {{0.0, -1.0}});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("duration_s")));
}

}  // namespace
}  // namespace plenum::host::plant::regulator_valve
