#include "host-sim/identify/chamber/noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <random>

namespace plenum::host::identify::chamber {
namespace {

constexpr std::size_t kWindow = 25;
constexpr double kCalmShare = 0.3;
/// The 0.3 quantile of the root mean square of kWindow third differences of white noise over its expectation
/// (200,000 simulated windows).
constexpr double kQuantileOfCalm = 0.860;

constexpr std::size_t kBlock = 20;  // rows
/// Blocks drawn together, at most: what is slower than that counts as if it were not. Of few blocks fewer, so that so many stretches
/// at least differ: a stretch of nearly all of them has nearly their own mean, as if that were exactly known.
constexpr std::size_t kLongestStretch = 10;
constexpr std::size_t kLeastStretches = 10;
constexpr int kDraws = 999;

/// Of the means over blocks, times a block's rows: of white noise the variance.
std::vector<double> block_squares(const std::vector<double>& error) {
  std::vector<double> squares;
  for (std::size_t begin = 0; begin + kBlock <= error.size(); begin += kBlock) {
    const double sum = std::accumulate(error.begin() + static_cast<std::ptrdiff_t>(begin),
                                       error.begin() + static_cast<std::ptrdiff_t>(begin + kBlock), 0.0);
    squares.push_back(sum * sum / static_cast<double>(kBlock));
  }
  return squares;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

double white_noise(const std::vector<double>& signal) {
  if (signal.size() < 4 * kWindow) return 0.0;
  std::vector<double> windows;
  for (std::size_t begin = 0; begin + kWindow + 3 <= signal.size(); begin += kWindow) {
    double sum = 0.0;
    for (std::size_t i = begin; i < begin + kWindow; ++i) {
      const double third = signal[i + 3] - 3.0 * signal[i + 2] + 3.0 * signal[i + 1] - signal[i];
      sum += third * third;
    }
    // a reading that stands still to the bit shows no noise: of a sensor at the end of its range, or of coarse steps
    if (sum > 0.0) windows.push_back(std::sqrt(sum / (20.0 * kWindow)));
  }
  if (windows.empty()) return 0.0;
  const auto at =
      windows.begin() + static_cast<std::ptrdiff_t>(kCalmShare * static_cast<double>(windows.size()));
  std::nth_element(windows.begin(), at, windows.end());
  return *at / kQuantileOfCalm;
}

double correlation_rows(const std::vector<double>& error) {
  const std::size_t n = error.size();
  double power = 0.0;
  for (const double e : error) power += e * e;
  if (n < 4 || power <= 0.0) return 1.0;
  double rows = 1.0;
  for (std::size_t lag = 1; lag < std::min<std::size_t>(n / 4, 400); ++lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < n; ++i) sum += error[i] * error[i - lag];
    const double rho = sum / power;
    if (rho < 0.05) break;
    rows += 2.0 * rho;
  }
  return rows;
}

double probability_of_noise(const std::vector<double>& error, const std::vector<double>& noise,
                            std::size_t fitted_to_noise, double sigma, double greatest) {
  const std::vector<double> of_error = block_squares(error);
  const std::vector<double> of_noise = block_squares(noise);
  if (of_error.empty() || of_noise.empty() || sigma <= 0.0) return 1.0;
  const double most = sigma * sigma + static_cast<double>(kBlock) * (greatest * greatest - sigma * sigma);
  const auto blocks = static_cast<double>(of_noise.size());
  const double free = std::max(blocks - static_cast<double>(fitted_to_noise), 1.0);
  const double left = mean(of_noise);
  const double before_fit = std::max(left, std::min(left * blocks / free, sigma * sigma));
  const double ratio = mean(of_error) / std::min(before_fit, most);
  const std::size_t stretch = std::clamp<std::size_t>(of_noise.size() / kLeastStretches, 1, kLongestStretch);
  std::mt19937 random(1);
  const auto drawn = [&](std::size_t count) {  // their mean square
    double sum = 0.0;
    for (std::size_t i = 0, at = 0; i < count; ++i, ++at) {
      if (i % stretch == 0) at = random() % of_noise.size();
      sum += of_noise[at % of_noise.size()];
    }
    return sum / static_cast<double>(count);
  };
  int as_far = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double error_drawn = drawn(of_error.size());
    as_far += error_drawn >= ratio * drawn(of_noise.size()) ? 1 : 0;
  }
  return (1.0 + as_far) / (1.0 + kDraws);
}

}  // namespace plenum::host::identify::chamber
