// Grids, figures over them, and order statistics of samples.
#pragma once

#include <cstddef>
#include <vector>

namespace plenum::host::reproduce {

/// `count` >= 2 values from low to high, evenly spaced.
std::vector<double> evenly(double low, double high, std::size_t count);

/// A figure of each of the values, in their order.
template <class Value, class Figure>
std::vector<double> over(const std::vector<Value>& values, const Figure& figure) {
  std::vector<double> figures;
  figures.reserve(values.size());
  for (const Value& value : values) figures.push_back(figure(value));
  return figures;
}

/// How many neighbours fall, and how many rise.
std::size_t falling_steps(const std::vector<double>& values);
std::size_t rising_steps(const std::vector<double>& values);

/// The greater of two; NaN where either is one, unlike std::max, so that a value that is none never passes for small.
double greater_of(double a, double b);
/// The lesser of two; NaN where either is one, unlike std::min.
double lesser_of(double a, double b);
/// The greatest of one or more; NaN where one is.
double largest(const std::vector<double>& values);
double mean(const std::vector<double>& values);

/// The value that `percent` of the values do not exceed (nearest rank); 0 < percent <= 100.
double percentile(std::vector<double> values, double percent);
double median(const std::vector<double>& values);

/// Place of the value that is the median by nearest rank.
std::size_t place_of_median(const std::vector<double>& values);

/// How many percent of the values are below `limit`.
double percent_below(const std::vector<double>& values, double limit);

/// Pearson's coefficient of correlation; `x` and `y` are of one length, at least 2.
double correlation(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace plenum::host::reproduce
