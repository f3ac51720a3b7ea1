#include "host-sim/reproduce/samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace plenum::host::reproduce {
namespace {

std::size_t rank(std::size_t count, double percent) {
  const double ceiling = std::ceil(percent / 100.0 * static_cast<double>(count));
  return static_cast<std::size_t>(std::clamp(ceiling, 1.0, static_cast<double>(count))) - 1;
}

}  // namespace

std::vector<double> evenly(double low, double high, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = low + (high - low) * static_cast<double>(i) / static_cast<double>(count - 1);
  }
  return values;
}

std::size_t falling_steps(const std::vector<double>& values) {
  std::size_t count = 0;
  for (std::size_t i = 1; i < values.size(); ++i) count += values[i] < values[i - 1] ? 1U : 0U;
  return count;
}

std::size_t rising_steps(const std::vector<double>& values) {
  std::size_t count = 0;
  for (std::size_t i = 1; i < values.size(); ++i) count += values[i] > values[i - 1] ? 1U : 0U;
  return count;
}

double greater_of(double a, double b) {
  return std::isnan(a) || a >= b ? a : b;
}

double lesser_of(double a, double b) {
  return std::isnan(a) || a <= b ? a : b;
}

double largest(const std::vector<double>& values) {
  return std::accumulate(values.begin() + 1, values.end(), values.front(), greater_of);
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double percentile(std::vector<double> values, double percent) {
  std::sort(values.begin(), values.end());
  return values[rank(values.size(), percent)];
}

double median(const std::vector<double>& values) {
  return percentile(values, 50.0);
}

std::size_t place_of_median(const std::vector<double>& values) {
  const auto found = std::find(values.begin(), values.end(), median(values));
  return static_cast<std::size_t>(found - values.begin());
}

double percent_below(const std::vector<double>& values, double limit) {
  const auto below = std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; });
  return 100.0 * static_cast<double>(below) / static_cast<double>(values.size());
}

double correlation(const std::vector<double>& x, const std::vector<double>& y) {
  const double x_mean = mean(x);
  const double y_mean = mean(y);
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - x_mean) * (x[i] - x_mean);
    yy += (y[i] - y_mean) * (y[i] - y_mean);
    xy += (x[i] - x_mean) * (y[i] - y_mean);
  }
  return xy / std::sqrt(xx * yy);
}

}  // namespace plenum::host::reproduce
