#include "host-sim/identify/sign_of_command.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace plenum::host::identify {
namespace {

constexpr double kLongest_s = 1.0;  ///< of a machine that is late by a quarter of a period, twice that
constexpr double kNearly = 0.8;     ///< correlation, less 1 for a copy

}  // namespace

bool turned_is_late(std::span<const double> command_V, double period_s) {
  const auto rows = static_cast<Eigen::Index>(command_V.size());
  const Eigen::Map<const Eigen::VectorXd> u(command_V.data(), rows);
  const Eigen::Index longest = std::min<Eigen::Index>(std::lround(kLongest_s / period_s), rows / 2);
  for (Eigen::Index late = 1; late <= longest; ++late) {
    const Eigen::VectorXd now = u.tail(rows - late).array() - u.tail(rows - late).mean();
    const Eigen::VectorXd before = u.head(rows - late).array() - u.head(rows - late).mean();
    if (now.dot(before) < -kNearly * now.norm() * before.norm()) return true;
  }
  return false;
}

}  // namespace plenum::host::identify
