#include "host-sim/blind/recalibrate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace plenum::host::blind {
namespace {

using Figures = Eigen::Matrix<double, 8, 1>;

constexpr int kMostTries = 14;
/// Of each figure: volts, logarithms of areas, and 10 kPa.
constexpr double kDifference = 1e-3;
constexpr double kInitialUnit_Pa = 10e3;
/// No figure goes further than a data sheet could be wrong, or an effect could be hidden: volts and e-folds.
constexpr double kThresholdReach_V = 0.5;
constexpr double kAreaReach = 4.0;

Machine changed(Machine machine, const Figures& change) {
  auto& valve = machine.rig.valve;
  valve.open_above_V += change(0);
  valve.exhaust_below_V += change(1);
  valve.inlet_area_per_V_m2 *= std::exp(change(2));
  valve.exhaust_area_per_V_m2 *= std::exp(change(3));
  valve.inlet_leak_m2 *= std::exp(change(4));
  valve.exhaust_leak_m2 *= std::exp(change(5));
  valve.transition_m2 *= std::exp(change(6));
  machine.initial_Pa = std::max(machine.initial_Pa + kInitialUnit_Pa * change(7), 1e3);
  return machine;
}

Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

}  // namespace

Recalibration::Recalibration(Machine nominal, std::vector<double> command_V)
    : nominal_(std::move(nominal)), command_V_(std::move(command_V)) {
  base_Pa_ = simulated(Figures::Zero());
  jacobian_.resize(base_Pa_.size(), 8);
  for (int i = 0; i < 8; ++i) {
    Figures change = Figures::Zero();
    change(i) = kDifference;
    jacobian_.col(i) = (simulated(change) - base_Pa_) / kDifference;
  }
}

Eigen::VectorXd Recalibration::simulated(const Figures& change) const {
  return as_vector(
      simulate(changed(nominal_, change), command_V_.size(), replay(command_V_), kCalibrationStep_s)
          .pressure_Pa);
}

double Recalibration::rest_Pa(const std::vector<double>& pressure_Pa) const {
  const Eigen::VectorXd wanted = as_vector(pressure_Pa);
  const Eigen::Matrix<double, 8, 8> gram = jacobian_.transpose() * jacobian_;
  Figures at = Figures::Zero();
  Eigen::VectorXd error = wanted - base_Pa_;
  double damping = 1e-6;
  for (int i = 0; i < kMostTries; ++i) {
    Eigen::Matrix<double, 8, 8> normal = gram;
    normal.diagonal() += damping * gram.diagonal();
    normal.diagonal().array() += 1e-9 * gram.trace();
    Figures next = at + normal.ldlt().solve(jacobian_.transpose() * error);
    for (int k = 0; k < 7; ++k) {
      const double reach = k < 2 ? kThresholdReach_V : kAreaReach;
      next(k) = std::clamp(next(k), -reach, reach);
    }
    const Eigen::VectorXd left = wanted - simulated(next);
    if (left.squaredNorm() < error.squaredNorm()) {
      const bool done = left.squaredNorm() > 0.99 * error.squaredNorm();
      at = next;
      error = left;
      damping *= 0.1;
      if (done) break;
    } else {
      damping = std::max(10.0 * damping, 1e-3);
      if (damping > 10.0) break;
    }
  }
  return std::sqrt(error.squaredNorm() / static_cast<double>(error.size()));
}

}  // namespace plenum::host::blind
