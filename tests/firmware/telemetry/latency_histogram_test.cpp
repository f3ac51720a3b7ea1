#include "firmware/telemetry/latency_histogram.hpp"

#include <gtest/gtest.h>

namespace plenum::telemetry {
namespace {

using Histogram = LatencyHistogram;

TEST(LatencyHistogram, BinsJoinWithoutGapAndAreAtMostAQuarterWide) {
  EXPECT_EQ(Histogram::lowest_us(0), 0U);
  EXPECT_EQ(Histogram::lowest_us(63), 114'688U);
  for (std::size_t bin = 0; bin + 1 < Histogram::kBins; ++bin) {
    const std::uint32_t low = Histogram::lowest_us(bin);
    const std::uint32_t high = Histogram::lowest_us(bin + 1) - 1;
    EXPECT_EQ(Histogram::bin_of(low), bin);
    EXPECT_EQ(Histogram::bin_of(high), bin);
    EXPECT_LE(4 * (high - low), low) << bin;
  }
}

TEST(LatencyHistogram, TheLastBinTakesEverythingBeyond) {
  EXPECT_EQ(Histogram::bin_of(131'071), 63U);
  EXPECT_EQ(Histogram::bin_of(131'072), 63U);
  EXPECT_EQ(Histogram::bin_of(UINT32_MAX), 63U);
}

TEST(LatencyHistogram, BeforeTheFirstTickAllIsZero) {
  const Histogram histogram;
  EXPECT_EQ(histogram.max_us(), 0U);
  EXPECT_EQ(histogram.p999_us(), 0U);
}

TEST(LatencyHistogram, OneInAThousandDoesNotCountAndTwoDo) {
  Histogram histogram;
  for (int tick = 0; tick < 999; ++tick) histogram.add(9);
  histogram.add(5000);
  EXPECT_EQ(histogram.p999_us(), 9U);  // its bin is 8 and 9
  EXPECT_EQ(histogram.max_us(), 5000U);
  histogram.add(5000);
  EXPECT_EQ(histogram.p999_us(), 5000U);  // its bin ends at 5119, and nothing was later than 5000
}

TEST(LatencyHistogram, EveryTickIsInItsBin) {
  Histogram histogram;
  histogram.add(10);
  histogram.add(11);
  histogram.add(200'000);
  EXPECT_EQ(histogram.count(Histogram::bin_of(10)), 2U);
  EXPECT_EQ(histogram.count(63), 1U);
  EXPECT_EQ(histogram.max_us(), 200'000U);
}

}  // namespace
}  // namespace plenum::telemetry
