#include "host-sim/identify/chamber/noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace plenum::host::identify::chamber {
namespace {

constexpr std::size_t kWindow = 25;
constexpr double kCalmShare = 0.3;
/// The 0.3 quantile of the root mean square of kWindow third differences of white noise over its expectation
/// (200,000 simulated windows).
constexpr double kQuantileOfCalm = 0.860;

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
    windows.push_back(std::sqrt(sum / (20.0 * kWindow)));
  }
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

double probability_of_noise(const std::vector<double>& error, double sigma) {
  constexpr std::size_t kBlock = 20;
  double chi2 = 0.0;
  double blocks = 0.0;
  for (std::size_t begin = 0; begin + kBlock <= error.size(); begin += kBlock) {
    const double sum = std::accumulate(error.begin() + static_cast<std::ptrdiff_t>(begin),
                                       error.begin() + static_cast<std::ptrdiff_t>(begin + kBlock), 0.0);
    chi2 += sum * sum / (static_cast<double>(kBlock) * sigma * sigma);
    blocks += 1.0;
  }
  if (blocks < 1.0) return 1.0;
  const double spread = 2.0 / (9.0 * blocks);
  const double z = (std::cbrt(chi2 / blocks) - (1.0 - spread)) / std::sqrt(spread);
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

}  // namespace plenum::host::identify::chamber
