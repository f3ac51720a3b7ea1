// Even grids for the curves of the charts.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace plenum::host::reproduce::proportional_valve {

/// `count` values from `low` to `high`, two or more.
inline std::vector<double> even_grid(double low, double high, std::size_t count) {
  std::vector<double> grid;
  for (std::size_t i = 0; i < count; ++i)
    grid.push_back(low + (high - low) * static_cast<double>(i) / static_cast<double>(count - 1));
  return grid;
}

inline std::vector<double> mapped(const std::vector<double>& x, const std::function<double(double)>& f) {
  std::vector<double> y;
  y.reserve(x.size());
  for (const double value : x) y.push_back(f(value));
  return y;
}

}  // namespace plenum::host::reproduce::proportional_valve
