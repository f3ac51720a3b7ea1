#include "host-sim/identify/servo/bipolynomial.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::servo {

double Bipolynomial::flow_kg_s(double command_V, double pressure_Pa) const {
  double sum = 0.0;
  for (std::size_t m = 3; m-- > 0;)
    sum = sum * command_V + (c[m][0] + pressure_Pa * (c[m][1] + pressure_Pa * c[m][2]));
  return sum;
}

BipolynomialFit fit_bipolynomial(std::span<const FlowSample> samples, Terms terms) {
  std::vector<std::pair<int, int>> powers;
  for (int m = 0; m < 3; ++m)
    for (int n = 0; n < 3; ++n)
      if (terms == Terms::kWhole || m != 1 || n != 0) powers.emplace_back(m, n);
  const auto columns = static_cast<Eigen::Index>(powers.size());
  const auto rows = static_cast<Eigen::Index>(samples.size());
  double largest_u = 0.0;
  double largest_P = 0.0;
  require_finite(samples);
  for (const FlowSample& s : samples) {
    largest_u = std::max(largest_u, std::abs(s.command_V));
    largest_P = std::max(largest_P, std::abs(s.pressure_Pa));
  }
  if (rows < columns || largest_u == 0.0 || largest_P == 0.0) {
    throw CannotIdentify(fmt::format(
        "bipolynomial flow: {} samples for {} coefficients, expected more, off zero", rows, columns));
  }
  Eigen::MatrixXd X(rows, columns);
  Eigen::VectorXd y(rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const FlowSample& s = samples[static_cast<std::size_t>(row)];
    for (Eigen::Index column = 0; column < columns; ++column) {
      const auto [m, n] = powers[static_cast<std::size_t>(column)];
      X(row, column) = std::pow(s.command_V / largest_u, m) * std::pow(s.pressure_Pa / largest_P, n);
    }
    y[row] = s.flow_kg_s;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(X);
  qr.setThreshold(1e-10);
  if (qr.rank() < columns) {
    throw CannotIdentify(
        fmt::format("bipolynomial flow: the samples determine {} of {} coefficients; expected three commands "
                    "and pressures or more",
                    qr.rank(), columns));
  }
  const Eigen::VectorXd scaled = qr.solve(y);
  BipolynomialFit fit;
  for (Eigen::Index column = 0; column < columns; ++column) {
    const auto [m, n] = powers[static_cast<std::size_t>(column)];
    fit.polynomial.c[static_cast<std::size_t>(m)][static_cast<std::size_t>(n)] =
        scaled[column] / (std::pow(largest_u, m) * std::pow(largest_P, n));
  }
  const Eigen::VectorXd predicted = X * scaled;
  static_cast<FlowError&>(fit) =
      flow_error(samples, {predicted.data(), static_cast<std::size_t>(predicted.size())});
  return fit;
}

}  // namespace plenum::host::identify::servo
