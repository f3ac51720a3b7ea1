#include "host-sim/identify/chamber/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace plenum::host::identify::chamber {
namespace {

std::vector<double> white(std::size_t rows, double sigma, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<double> noise(rows);
  for (double& one : noise) one = normal(random);
  return noise;
}

TEST(WhiteNoise, IsRecoveredFromUnderAPressureThatSwingsAThousandTimesAsFar) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::vector<double> signal = white(4000, 120.0, seed);
    for (std::size_t i = 0; i < signal.size(); ++i)
      signal[i] += 4e5 + 1.2e5 * std::sin(0.01 * static_cast<double>(i));
    EXPECT_NEAR(white_noise(signal), 120.0, 8.0) << "seed " << seed;
  }
}

TEST(WhiteNoise, IsNotRaisedByJumpsThatComeOnceASecond) {
  std::vector<double> signal = white(4000, 120.0, 4);
  for (std::size_t i = 0; i < signal.size(); ++i) signal[i] += (i / 100) % 2 == 0 ? 2e5 : 5e5;
  EXPECT_NEAR(white_noise(signal), 120.0, 15.0);
}

TEST(WhiteNoise, IsZeroWhereTheSignalIsTooShortToTell) {
  EXPECT_EQ(white_noise(white(50, 1.0, 1)), 0.0);
}

TEST(CorrelationRows, IsOneForWhiteNoiseAndTheSumOfAFirstOrderProcess) {
  EXPECT_NEAR(correlation_rows(white(20000, 1.0, 5)), 1.0, 0.1);
  // x' = 0.9 x + e: autocorrelation 0.9^k, whose two-sided sum is 1.9/0.1 = 19; cut where it falls below 0.05
  std::vector<double> process = white(200000, 1.0, 6);
  for (std::size_t i = 1; i < process.size(); ++i) process[i] += 0.9 * process[i - 1];
  EXPECT_NEAR(correlation_rows(process), 18.0, 1.5);
}

TEST(ProbabilityOfNoise, IsUniformUnderNoiseAndVanishesForABiasOfHalfItsSigma) {
  int below_a_tenth = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    below_a_tenth += probability_of_noise(white(2000, 3.0, 100 + seed), 3.0) < 0.1 ? 1 : 0;
  }
  EXPECT_NEAR(below_a_tenth, 40, 20);
  std::vector<double> biased = white(2000, 3.0, 7);
  for (double& one : biased) one += 1.5;
  EXPECT_LT(probability_of_noise(biased, 3.0), 1e-6);
}

}  // namespace
}  // namespace plenum::host::identify::chamber
