#include "host-sim/identify/regulator_valve/fit_measure.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <stdexcept>

namespace plenum::host::identify::regulator_valve {

double fit_percent(const std::vector<double>& measured, const std::vector<double>& estimated) {
  if (measured.empty() || measured.size() != estimated.size()) {
    throw std::invalid_argument(
        fmt::format("fit_percent: {} measured and {} estimated, expected as many and some", measured.size(),
                    estimated.size()));
  }
  const auto count = static_cast<Eigen::Index>(measured.size());
  const Eigen::Map<const Eigen::ArrayXd> y(measured.data(), count);
  const Eigen::Map<const Eigen::ArrayXd> estimate(estimated.data(), count);
  const double spread = (y - y.mean()).matrix().norm();
  if (!(spread > 0.0))
    throw std::invalid_argument("fit_percent: the measurement never changes, expected a change");
  return 100.0 * (1.0 - (estimate - y).matrix().norm() / spread);
}

}  // namespace plenum::host::identify::regulator_valve
