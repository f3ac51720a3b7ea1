#include "host-sim/identify/orifice/filter.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

namespace plenum::host::identify::orifice {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

VesselRecord line(std::size_t rows, double start_Pa, double rate_Pa_s) {
  VesselRecord record;
  double t = 0.0;
  for (std::size_t i = 0; i < rows; ++i) {
    record.time_s.push_back(t);
    record.vessel_Pa.push_back(start_Pa + rate_Pa_s * t);
    record.far_Pa.push_back(7e5);
    t += i % 3 == 0 ? 0.002 : 0.001;  // uneven
  }
  return record;
}

TEST(CyclicAverage, IsTheMeanOfThePeriodsRowByRow) {
  EXPECT_THAT(cyclic_average({1, 2, 3, 5, 4, 1}, 2), ElementsAre(3, 3, 2));
}

TEST(CyclicAverage, RefusesBrokenPeriods) {
  EXPECT_THAT(
      [] {
        cyclic_average({1, 2, 3}, 2);
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("3 samples, expected 2 whole periods")));
}

TEST(MovingAverage, OfTenRowsNullsAHundredHertzAtOneKilohertz) {
  VesselRecord record;
  for (int i = 0; i < 200; ++i) {
    record.time_s.push_back(1e-3 * i);
    record.vessel_Pa.push_back(3e5 + 100.0 * std::sin(2.0 * std::numbers::pi * 100.0 * 1e-3 * i + 0.7));
    record.far_Pa.push_back(7e5);
  }
  EXPECT_THAT(moving_average(record, 10).vessel_Pa, Each(::testing::DoubleNear(3e5, 1e-6)));
  EXPECT_THAT(moving_average(record, 9).vessel_Pa, ::testing::Contains(::testing::Gt(3e5 + 5.0)));
}

TEST(MovingAverage, KeepsALineOnItselfAndTakesWholeWindowsOnly) {
  const VesselRecord filtered = moving_average(line(40, 2e5, 3e6), 7);
  ASSERT_EQ(filtered.time_s.size(), 34u);
  for (std::size_t i = 0; i < filtered.time_s.size(); ++i)
    EXPECT_NEAR(filtered.vessel_Pa[i], 2e5 + 3e6 * filtered.time_s[i], 1e-6);
}

TEST(BlockMeans, KeepALineOnItself) {
  const VesselRecord means = block_means(line(45, 2e5, 3e6), 10);
  ASSERT_EQ(means.time_s.size(), 4u);
  for (std::size_t i = 0; i < means.time_s.size(); ++i)
    EXPECT_NEAR(means.vessel_Pa[i], 2e5 + 3e6 * means.time_s[i], 1e-6);
}

TEST(Rows, AreThoseOfEveryColumn) {
  const VesselRecord whole = line(9, 2e5, 3e6);
  const VesselRecord part = rows_of(whole, 2, 5);
  EXPECT_EQ(part.flow, whole.flow);
  EXPECT_THAT(part.time_s, ElementsAre(whole.time_s[2], whole.time_s[3], whole.time_s[4]));
  EXPECT_THAT(part.vessel_Pa, ElementsAre(whole.vessel_Pa[2], whole.vessel_Pa[3], whole.vessel_Pa[4]));
  EXPECT_EQ(part.far_Pa.size(), 3U);
  EXPECT_THAT(
      [] { rows_of(line(9, 2e5, 3e6), 2, 10); },
      ThrowsMessage<std::invalid_argument>(HasSubstr("rows_of: 2 to 10, expected rows of the record's 9")));
  EXPECT_THROW(rows_of(whole, 3, 2), std::invalid_argument);
}

TEST(SteadyFarSide, KeepsTheMeanOfTheFarPressureAlone) {
  VesselRecord record = line(4, 2e5, 3e6);
  record.far_Pa = {6e5, 8e5, 6.5e5, 7.5e5};
  const VesselRecord steady = steady_far_side(record);
  EXPECT_THAT(steady.far_Pa, Each(7e5));
  EXPECT_EQ(steady.vessel_Pa, record.vessel_Pa);
}

TEST(Rate, OfALineIsItsSlopeAtUnevenTimes) {
  EXPECT_THAT(differentiated(line(40, 2e5, 3e6)).rate_Pa_s, Each(::testing::DoubleNear(3e6, 1e-3)));
}

// Of 2000 draws: 1.26/sqrt(2000), the median's, of it is 3 %, and neighbours share draws.
TEST(Noise, IsThatOnASmoothSignalAndNotItsStep) {
  std::mt19937 random(1);
  std::normal_distribution<double> white(0.0, 200.0);
  std::vector<double> signal;
  for (int i = 0; i < 2000; ++i)
    signal.push_back(7e5 * std::exp(-1e-3 * i) + (i < 700 ? 0.0 : 5e4) + white(random));
  EXPECT_NEAR(noise_deviation(signal), 200.0, 0.1 * 200.0);
  EXPECT_THROW(noise_deviation({1.0, 2.0}), std::invalid_argument);
}

TEST(Filters, RefuseAWindowLongerThanTheRecord) {
  EXPECT_THAT([] { moving_average(line(5, 2e5, 0.0), 6); },
              ThrowsMessage<std::invalid_argument>(
                  HasSubstr("moving_average: 6 rows, expected 1 to the record's 5")));
  EXPECT_THAT([] { block_means(line(5, 2e5, 0.0), 0); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("block_means: 0 rows")));
}

}  // namespace
}  // namespace plenum::host::identify::orifice
