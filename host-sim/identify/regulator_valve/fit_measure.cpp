#include "host-sim/identify/regulator_valve/fit_measure.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"

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
  // not by the spread, which rounding of the mean leaves above 0
  if (y.minCoeff() == y.maxCoeff()) throw CannotIdentify("fit (39): the measurement never changes");
  return 100.0 * (1.0 - (estimate - y).matrix().norm() / (y - y.mean()).matrix().norm());
}

}  // namespace plenum::host::identify::regulator_valve
