#include "host-sim/blind/recalibrate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace plenum::host::blind {
namespace {

using Figures = Eigen::Matrix<double, 8, 1>;

constexpr int kMostTries = 20;
/// In the units below.
constexpr double kDifference = 1e-3;
/// Areas count linearly, since the pressure's rate does: then what scales with volume or adds to a leak is found at
/// once. Units: volts, the figure itself for gains and transition, and these.
constexpr double kLeakUnit_m2 = 1e-7;
constexpr double kInitialUnit_Pa = 10e3;
constexpr double kSmallestTransition_m2 = 1e-9;

/// No figure goes further than an effect could push it: thresholds by 0.5 V, gains to a fifth or five times.
Figures held(Figures change) {
  for (int i : {0, 1}) change(i) = std::clamp(change(i), -0.5, 0.5);
  for (int i : {2, 3}) change(i) = std::clamp(change(i), -0.8, 4.0);
  for (int i : {4, 5}) change(i) = std::clamp(change(i), -50.0, 50.0);
  change(6) = std::clamp(change(6), -1.0, 20.0);
  return change;
}

Machine changed(Machine machine, const Figures& change) {
  auto& valve = machine.rig.valve;
  valve.open_above_V += change(0);
  valve.exhaust_below_V += change(1);
  valve.inlet_area_per_V_m2 *= 1.0 + change(2);
  valve.exhaust_area_per_V_m2 *= 1.0 + change(3);
  valve.inlet_leak_m2 = std::max(valve.inlet_leak_m2 + kLeakUnit_m2 * change(4), 0.0);
  valve.exhaust_leak_m2 = std::max(valve.exhaust_leak_m2 + kLeakUnit_m2 * change(5), 0.0);
  valve.transition_m2 = std::max(valve.transition_m2 * (1.0 + change(6)), kSmallestTransition_m2);
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
  Eigen::Matrix<double, Eigen::Dynamic, 8> jacobian = jacobian_;
  Figures at = Figures::Zero();
  Eigen::VectorXd error = wanted - base_Pa_;
  double damping = 1e-6;
  int poor = 0;
  for (int i = 0; i < kMostTries && poor < 3; ++i) {
    Eigen::Matrix<double, 8, 8> normal = jacobian.transpose() * jacobian;
    normal.diagonal() *= 1.0 + damping;
    normal.diagonal().array() += 1e-10 * normal.trace();
    const Figures next = held(at + normal.ldlt().solve(jacobian.transpose() * error));
    const Figures moved = next - at;
    if (moved.squaredNorm() < 1e-14) break;
    const Eigen::VectorXd left = wanted - simulated(next);
    // Broyden's update: the least change of the Jacobian that tells of this move what was found.
    jacobian += (error - left - jacobian * moved) * (moved.transpose() / moved.squaredNorm());
    if (left.squaredNorm() < error.squaredNorm()) {
      poor = left.squaredNorm() > 0.98 * error.squaredNorm() ? poor + 1 : 0;
      at = next;
      error = left;
      damping *= 0.1;
    } else {
      ++poor;
      damping = std::max(10.0 * damping, 1e-3);
    }
  }
  return std::sqrt(error.squaredNorm() / static_cast<double>(error.size()));
}

}  // namespace plenum::host::blind
