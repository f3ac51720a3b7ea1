#include "host-sim/blind/recalibrate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace plenum::host::blind {
namespace {

using Figures = Eigen::Matrix<double, 8, 1>;

constexpr int kMostTries = 20;
/// Below any floor by far: no need to go on.
constexpr double kNegligible_Pa = 2.0;
constexpr int kMostPoor = 3;  // tries that gain nothing, or hardly anything
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
  jacobian_ = differences(Figures::Zero(), base_Pa_);
}

Eigen::VectorXd Recalibration::simulated(const Figures& change) const {
  return as_vector(
      simulate(changed(nominal_, change), command_V_.size(), replay(command_V_), kCalibrationStep_s)
          .pressure_Pa);
}

Recalibration::Jacobian Recalibration::differences(const Figures& at, const Eigen::VectorXd& there_Pa) const {
  Jacobian slopes(there_Pa.size(), 8);
  for (int i = 0; i < 8; ++i) {
    Figures change = at;
    change(i) += kDifference;
    slopes.col(i) = (simulated(change) - there_Pa) / kDifference;
  }
  return slopes;
}

double Recalibration::rest_Pa(const std::vector<double>& pressure_Pa) const {
  Search search{Figures::Zero(), as_vector(pressure_Pa) - base_Pa_, jacobian_};
  const double gap = search.error.norm();
  descend(search, as_vector(pressure_Pa));
  // What is mostly absorbed may be so wholly: then the slopes are worth taking anew.
  const double enough = kNegligible_Pa * std::sqrt(static_cast<double>(search.error.size()));
  if (search.error.norm() < 0.5 * gap && search.error.norm() > enough) {
    search.slopes = differences(search.at, as_vector(pressure_Pa) - search.error);
    descend(search, as_vector(pressure_Pa));
  }
  return search.error.norm() / std::sqrt(static_cast<double>(search.error.size()));
}

void Recalibration::descend(Search& search, const Eigen::VectorXd& wanted_Pa) const {
  double damping = 1e-6;
  int poor = 0;
  const double enough = kNegligible_Pa * std::sqrt(static_cast<double>(wanted_Pa.size()));
  for (int i = 0; i < kMostTries && poor < kMostPoor && search.error.norm() > enough; ++i) {
    Eigen::Matrix<double, 8, 8> normal = search.slopes.transpose() * search.slopes;
    normal.diagonal() *= 1.0 + damping;
    normal.diagonal().array() += 1e-10 * normal.trace();
    const Figures next = held(search.at + normal.ldlt().solve(search.slopes.transpose() * search.error));
    const Figures moved = next - search.at;
    if (moved.squaredNorm() < 1e-14) break;
    const Eigen::VectorXd left = wanted_Pa - simulated(next);
    // Broyden's update: the least change of the slopes that tells of this move what was found.
    search.slopes +=
        (search.error - left - search.slopes * moved) * (moved.transpose() / moved.squaredNorm());
    if (left.squaredNorm() < search.error.squaredNorm()) {
      poor = left.squaredNorm() > 0.95 * search.error.squaredNorm() ? poor + 1 : 0;
      search.at = next;
      search.error = left;
      damping *= 0.1;
    } else {
      ++poor;
      damping = std::max(30.0 * damping, 0.03);
    }
  }
}

}  // namespace plenum::host::blind
