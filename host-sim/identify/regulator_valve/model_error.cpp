#include "host-sim/identify/regulator_valve/model_error.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

namespace plenum::host::identify::regulator_valve {
namespace {

using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, 4>;

constexpr std::size_t kFewest = 8;    // samples
constexpr double kDependent = 1e-12;  // pivot below which a column is a sum of the others
constexpr double kDifference = 1e-5;  // of b, and of the residue: on its scale gain and slowest pole bend

DiscreteModel moved(DiscreteModel model, Eigen::Index coefficient, double by) {
  (coefficient == 3 ? model.b_Pa_m : model.a[static_cast<std::size_t>(coefficient)]) += by;
  return model;
}

// The slopes of `of` over a_1, a_2, a_3, b. What they make of the covariance cancels by orders of magnitude, so a step is
// as small as rounding allows.
template <class Of>
Eigen::Vector4d slopes(const DiscreteModel& model, const Of& of) {
  Eigen::Vector4d slope;
  for (Eigen::Index i = 0; i < 4; ++i) {
    const double step = kDifference * std::abs(i == 3 ? model.b_Pa_m : model.residue());
    slope[i] = (of(moved(model, i, step)) - of(moved(model, i, -step))) / (2.0 * step);
  }
  return slope;
}

double spread(const Eigen::Vector4d& slope, const Eigen::Matrix4d& covariance) {
  return std::sqrt(slope.dot(covariance * slope));
}

ModelError error_of(const DiscreteModel& model, const Jacobian& J, double squares) {
  ModelError error;
  const Eigen::RowVector4d length = J.colwise().norm();
  if (!(length.minCoeff() > 0.0) || !length.allFinite()) {
    error.covariance.setConstant(std::numeric_limits<double>::infinity());
  } else {
    Eigen::ColPivHouseholderQR<Jacobian> qr(J * length.cwiseInverse().asDiagonal());
    qr.setThreshold(kDependent);
    if (qr.rank() < 4) {
      error.covariance.setConstant(std::numeric_limits<double>::infinity());
    } else {
      const Eigen::Matrix4d R = qr.matrixR().topRows<4>().triangularView<Eigen::Upper>();
      const Eigen::Matrix4d root =
          length.cwiseInverse().asDiagonal() *
          Eigen::Matrix4d(qr.colsPermutation() * Eigen::Matrix4d(R.triangularView<Eigen::Upper>().solve(
                                                     Eigen::Matrix4d::Identity())));
      error.covariance = squares / static_cast<double>(J.rows() - 4) * root * root.transpose();
    }
  }
  if (!error.covariance.allFinite()) {
    error.static_gain_Pa_m = error.slowest_time_constant_s = std::numeric_limits<double>::infinity();
    return error;
  }
  error.static_gain_Pa_m =
      spread(slopes(model, [](const DiscreteModel& m) { return m.static_gain_Pa_m(); }), error.covariance);
  const double constant = spread(
      slopes(model, [](const DiscreteModel& m) { return slowest_time_constant_s(m); }), error.covariance);
  error.slowest_time_constant_s =
      std::isfinite(constant) ? constant : std::numeric_limits<double>::infinity();
  return error;
}

void require_long(const Branch& branch) {
  validate(branch);
  if (branch.pressure_Pa.size() < kFewest) {
    throw std::invalid_argument(
        fmt::format("branch: {} samples, expected at least {}", branch.pressure_Pa.size(), kFewest));
  }
}

Eigen::RowVector4d past(const std::vector<double>& p, const Branch& branch, std::size_t k) {
  return {-p[k - 1], -p[k - 2], -p[k - 3], branch.screw_m[k - 1]};
}

}  // namespace

double ModelError::coefficient(Eigen::Index i) const {
  return std::sqrt(covariance(i, i));
}

ModelError one_step_error(const DiscreteModel& model, const Branch& branch) {
  require_long(branch);
  const std::vector<double>& p = branch.pressure_Pa;
  const Eigen::Vector4d Theta(model.a[0], model.a[1], model.a[2], model.b_Pa_m);
  Jacobian J(static_cast<Eigen::Index>(p.size() - 3), 4);
  double squares = 0.0;
  for (std::size_t k = 3; k < p.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k - 3);
    J.row(row) = past(p, branch, k);
    squares += std::pow(p[k] - J.row(row).dot(Theta), 2);
  }
  return error_of(model, J, squares);
}

ModelError free_run_error(const DiscreteModel& model, const Branch& branch) {
  require_long(branch);
  const std::vector<double> run = free_run(model, branch.screw_m, branch.pressure_Pa);
  Jacobian J = Jacobian::Zero(static_cast<Eigen::Index>(run.size()), 4);
  double squares = 0.0;
  for (std::size_t k = 3; k < run.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    J.row(row) = past(run, branch, k);
    for (Eigen::Index i = 0; i < 3; ++i)
      J.row(row) -= model.a[static_cast<std::size_t>(i)] * J.row(row - 1 - i);
    squares += std::pow(branch.pressure_Pa[k] - run[k], 2);
  }
  return error_of(model, J.bottomRows(J.rows() - 3), squares);
}

InternalParameters internal_parameter_errors(const DiscreteModel& rising, const ModelError& rising_error,
                                             const DiscreteModel& falling, const ModelError& falling_error,
                                             const SystemConstants& constants) {
  InternalParameters errors;
  for (double InternalParameters::*const field :
       {&InternalParameters::diaphragm_area_m2, &InternalParameters::plunger_mass_kg,
        &InternalParameters::spool_mass_kg, &InternalParameters::plunger_spring_N_m,
        &InternalParameters::spool_spring_N_m, &InternalParameters::inlet_width_m,
        &InternalParameters::exhaust_width_m, &InternalParameters::rest_Pa,
        &InternalParameters::exhaustion_diaphragm_area_m2}) {
    const Eigen::Vector4d over_rising = slopes(
        rising, [&](const DiscreteModel& m) { return internal_parameters(m, falling, constants).*field; });
    const Eigen::Vector4d over_falling = slopes(
        falling, [&](const DiscreteModel& m) { return internal_parameters(rising, m, constants).*field; });
    errors.*field = std::hypot(spread(over_rising, rising_error.covariance),
                               spread(over_falling, falling_error.covariance));
  }
  return errors;
}

}  // namespace plenum::host::identify::regulator_valve
