#include "host-sim/reproduce/samples.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace plenum::host::reproduce {
namespace {

using testing::ElementsAre;

TEST(Samples, GridEndsWhereItIsTold) {
  EXPECT_THAT(evenly(3.0, 7.0, 5), ElementsAre(3.0, 4.0, 5.0, 6.0, 7.0));
}

TEST(Samples, StepsAreCountedByDirectionAndEqualNeighboursAreNone) {
  const std::vector<double> values{1.0, 2.0, 2.0, 1.0, 0.0};
  EXPECT_EQ(rising_steps(values), 1U);
  EXPECT_EQ(falling_steps(values), 2U);
}

TEST(Samples, PercentileIsTheNearestRank) {
  const std::vector<double> values{30.0, 10.0, 20.0, 40.0};
  EXPECT_EQ(percentile(values, 25.0), 10.0);
  EXPECT_EQ(percentile(values, 25.1), 20.0);
  EXPECT_EQ(percentile(values, 100.0), 40.0);
  EXPECT_EQ(percentile(values, 1e-9), 10.0);
  EXPECT_EQ(median(values), 20.0);
  EXPECT_EQ(place_of_median(values), 2U);
  std::vector<double> population;
  for (int i = 1; i <= 76; ++i) population.push_back(i);
  EXPECT_EQ(percentile(population, 95.0), 73.0);
}

TEST(Samples, WhatIsNoNumberIsNeverLost) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(greater_of(none, 1.0)));
  EXPECT_TRUE(std::isnan(greater_of(1.0, none)));
  EXPECT_EQ(greater_of(1.0, 2.0), 2.0);
  EXPECT_TRUE(std::isnan(lesser_of(none, 1.0)));
  EXPECT_TRUE(std::isnan(lesser_of(1.0, none)));
  EXPECT_EQ(lesser_of(1.0, 2.0), 1.0);
  EXPECT_EQ(lesser_of(2.0, 1.0), 1.0);
  EXPECT_EQ(largest({-3.0, -1.0, -2.0}), -1.0);
  EXPECT_TRUE(std::isnan(largest({1.0, none, 2.0})));
}

TEST(Samples, ShareBelowALimitLeavesTheLimitOut) {
  EXPECT_EQ(percent_below({1.0, 2.0, 3.0, 4.0}, 3.0), 50.0);
}

TEST(Samples, CorrelationOfALineIsItsSign) {
  const std::vector<double> x{1.0, 2.0, 4.0, 8.0};
  EXPECT_NEAR(correlation(x, {3.0, 5.0, 9.0, 17.0}), 1.0, 1e-15);
  EXPECT_NEAR(correlation(x, {-3.0, -5.0, -9.0, -17.0}), -1.0, 1e-15);
  EXPECT_NEAR(correlation({-1.0, 0.0, 1.0}, {1.0, 0.0, 1.0}), 0.0, 1e-15);
}

}  // namespace
}  // namespace plenum::host::reproduce
