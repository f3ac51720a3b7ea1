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

/// White noise of 3 on a first-order process of so much that remembers 50 rows.
std::vector<double> coloured(std::size_t rows, double slow, unsigned seed) {
  std::vector<double> noise = white(rows, 3.0, seed);
  const std::vector<double> drive = white(rows, slow * std::sqrt(1.0 - 0.98 * 0.98), seed + 1000);
  double state = drive.front();
  for (std::size_t i = 0; i < rows; ++i) {
    state = 0.98 * state + drive[i];
    noise[i] += state;
  }
  return noise;
}

TEST(ProbabilityOfNoise, IsUniformUnderNoiseWhiteOrSlow) {
  for (const double slow : {0.0, 0.6}) {
    int below_a_tenth = 0, above_nine = 0;
    for (unsigned seed = 0; seed < 400; ++seed) {
      const double p = probability_of_noise(coloured(2400, slow, 5000 + seed),
                                            coloured(4000, slow, 100 + seed), 0, 3.0, 1.12 * 3.0);
      below_a_tenth += p < 0.1 ? 1 : 0;
      above_nine += p > 0.9 ? 1 : 0;
    }
    EXPECT_NEAR(below_a_tenth, 40, 20) << "slow " << slow;
    EXPECT_NEAR(above_nine, 40, 20) << "slow " << slow;
  }
}

TEST(ProbabilityOfNoise, OfFewRowsIsNoMoreCertain) {
  int below = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    const double p = probability_of_noise(coloured(160, 0.0, 5000 + seed), coloured(240, 0.0, 100 + seed), 0,
                                          3.0, 1.12 * 3.0);
    below += p < 0.01 ? 1 : 0;
  }
  EXPECT_LE(below, 16) << "4 expected, not one in three";
}

TEST(ProbabilityOfNoise, AllowsForFiguresThatHaveFollowedItWhereBlocksAreFew) {
  const auto below_a_tenth = [](std::size_t figures) {
    int below = 0;
    for (unsigned seed = 0; seed < 200; ++seed) {
      // of twelve blocks eight figures leave a third
      const std::vector<double> followed = white(240, 3.0 / std::sqrt(3.0), 100 + seed);
      below += probability_of_noise(white(160, 3.0, 5000 + seed), followed, figures, 3.0, 1.12 * 3.0) < 0.1
                   ? 1
                   : 0;
    }
    return below;
  };
  EXPECT_GT(below_a_tenth(0), 80);
  EXPECT_NEAR(below_a_tenth(8), 20, 15);
  EXPECT_LT(probability_of_noise(white(160, 9.0, 1), white(240, 1.0, 2), 1000, 3.0, 1.12 * 3.0), 0.01)
      << "they followed no more than white noise";
}

TEST(ProbabilityOfNoise, IsLeastForABiasOfHalfItsSigmaWhateverTheNoiseIsSaidToBe) {
  std::vector<double> biased = white(2400, 3.0, 7);
  for (double& one : biased) one += 1.5;
  EXPECT_EQ(probability_of_noise(biased, white(4000, 3.0, 8), 0, 3.0, 1.12 * 3.0), 0.001);
  std::vector<double> gap =
      coloured(2400, 9.0, 9);  // an error that nothing explains, of fitted rows as of these
  EXPECT_EQ(probability_of_noise(gap, coloured(4000, 9.0, 10), 0, 3.0, 1.12 * 3.0), 0.001);
}

TEST(ProbabilityOfNoise, IsOneWithoutABlock) {
  EXPECT_EQ(probability_of_noise(white(19, 3.0, 1), white(4000, 3.0, 2), 0, 3.0, 3.3), 1.0);
  EXPECT_EQ(probability_of_noise(white(4000, 3.0, 1), {}, 0, 3.0, 3.3), 1.0);
}

}  // namespace
}  // namespace plenum::host::identify::chamber
