// A fault of a machine that several tests put before the plant.
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace plenum::host::diagnose {

/// A valve at which a command arrives so late, told of each millisecond's.
class LateValve {
 public:
  explicit LateValve(double late_s) : past_V_(static_cast<std::size_t>(std::lround(1e3 * late_s)), 5.0) {}
  double operator()(double u_V) {
    const double late_V = std::exchange(past_V_[next_], u_V);
    next_ = (next_ + 1) % past_V_.size();
    return late_V;
  }

 private:
  std::vector<double> past_V_;
  std::size_t next_ = 0;
};

}  // namespace plenum::host::diagnose
