#include "host-sim/identify/regulator_valve/least_squares.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cstddef>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

constexpr std::size_t kFewest = 8;    // samples: as many rows as coefficients, and one
constexpr double kDependent = 1e-12;  // pivot of Psi below which a column is a sum of the others

}  // namespace

DiscreteModel fit_least_squares(const Branch& branch) {
  validate(branch);
  const std::size_t samples = branch.pressure_Pa.size();
  if (samples < kFewest) {
    throw CannotIdentify(fmt::format("least squares: {} samples, expected at least {}", samples, kFewest));
  }
  const auto rows = static_cast<Eigen::Index>(samples - 3);
  Eigen::Matrix<double, Eigen::Dynamic, 4> Psi(rows, 4);
  Eigen::VectorXd Y(rows);
  for (std::size_t k = 3; k < samples; ++k) {
    const auto& p = branch.pressure_Pa;
    Psi.row(static_cast<Eigen::Index>(k - 3)) << -p[k - 1], -p[k - 2], -p[k - 3], branch.screw_m[k - 1];
    Y[static_cast<Eigen::Index>(k - 3)] = p[k];
  }
  const Eigen::RowVector4d scale = Psi.colwise().norm();  // pascals beside metres
  if (!(scale.minCoeff() > 0.0)) {
    throw CannotIdentify(
        fmt::format("least squares: {} never changes", scale[3] > 0.0 ? "the pressure" : "the screw"));
  }
  const Eigen::Matrix<double, Eigen::Dynamic, 4> scaled = Psi * scale.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, 4>> qr(scaled);
  qr.setThreshold(kDependent);
  if (qr.rank() < 4) {
    throw CannotIdentify(fmt::format(
        "least squares: rank {} of 4, past pressures and screw depend on each other: no excitation",
        qr.rank()));
  }
  const Eigen::Vector4d Theta = qr.solve(Y).cwiseQuotient(scale.transpose());
  return {.b_Pa_m = Theta[3], .a = {Theta[0], Theta[1], Theta[2]}, .sample_s = branch.sample_s};
}

}  // namespace plenum::host::identify::regulator_valve
