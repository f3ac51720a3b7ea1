#include "host-sim/diagnose/trust.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plenum::host::diagnose {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(Trust, InAFirstNameFallsWithWhatItLeaves) {
  EXPECT_GT(probability_of_first(1.0), 0.95);
  EXPECT_NEAR(probability_of_first(22.0), 0.495, 1e-3) << "even odds, of 99 %";
  EXPECT_LT(probability_of_first(1000.0), 0.01);
}

TEST(Trust, InANameBesideOthersRisesWithWhatItClosesOfTheRest) {
  EXPECT_LT(probability_beside_others(0.4), 0.05);
  EXPECT_NEAR(probability_beside_others(0.63), 0.475, 1e-3);
  EXPECT_GT(probability_beside_others(0.9), 0.85);
}

TEST(Trust, InANameBesideOthersIsNoMoreThanInTheFirstWhereAllLeaveMuch) {
  for (const double left : {1.0, 8.0, 40.0, 400.0})
    EXPECT_LT(worth_of_name(left, 1.0), worth_of_name(left, std::nullopt)) << left << " times the noise";
  EXPECT_NEAR(worth_of_name(40.0, 0.8), 0.21, 0.01) << "0.90 beside others, of 0.23 for any name there";
  EXPECT_NEAR(worth_of_name(1.0, 0.8), 0.89, 0.01);
}

TEST(Trust, FiguresThatMayVanishOrBeAnythingSayNothing) {
  const auto flow = effects::kIdFlowFunction;
  const effects::Size size;
  const auto of = [](const char* name, double low, double high) {
    return Estimate{name, 0.5 * (low + high), low, high, false};
  };
  EXPECT_TRUE(says_nothing({of("critical_ratio", 0.05, 0.8), of("subsonic_index", 0.25, 1.5)}, flow, size));
  EXPECT_TRUE(says_nothing({of("critical_ratio", 0.4, 0.6), of("discharge_slope", -0.1, 0.2)}, flow, size))
      << "both may be those of the thin plate";
  EXPECT_FALSE(says_nothing({of("critical_ratio", 0.2, 0.3), of("subsonic_index", 0.25, 1.5)}, flow, size))
      << "one is known";
  EXPECT_FALSE(says_nothing({of("critical_ratio", 0.05, 0.3)}, flow, size))
      << "at a bound, and not the thin plate's";
  // a frequency vanishes at infinity, and is held as its reciprocal
  EXPECT_TRUE(says_nothing({of("natural_frequency_Hz", 70.0, kInfinite)}, effects::kIdSpoolLag, size));
  EXPECT_FALSE(says_nothing({of("natural_frequency_Hz", 10.0, 14.0)}, effects::kIdSpoolLag, size));
}

}  // namespace
}  // namespace plenum::host::diagnose
