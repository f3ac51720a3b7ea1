#include "host-sim/identify/servo/cylinder_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host-sim/identify/box_solver.hpp"
#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::servo {
namespace {

using plant::servo::ServoCylinder;
using plant::servo::ValvePair;

constexpr int kFigures = static_cast<int>(kFittedNames.size());
constexpr int kNull = 2;
constexpr double kNullUnit_V = 0.05;  // one unit of the variable of the null
constexpr double kMillimetre = 1e-3;  // unit of the errors
constexpr double kStep = 1e-4;        // of the forward differences
constexpr int kMostIterations = 25;
constexpr double kTolerance = 1e-4;  // of the sum of squares: far below what the model lacks
constexpr double kFirstHorizon_s = 1.0;
constexpr std::size_t kGrowth = 3;  // of the horizon

using Variables = BoxVector<Eigen::Dynamic>;

ServoRig rig_at(const ServoRig& guess, const Variables& z) {
  ServoRig rig = guess;
  rig.valve.inlet_area_per_V_m2 *= std::exp(z[0]);
  rig.valve.exhaust_area_per_V_m2 *= std::exp(z[1]);
  rig.valve.open_above_V += kNullUnit_V * z[kNull];
  rig.valve.exhaust_below_V += kNullUnit_V * z[kNull];
  rig.cylinder.friction.coulomb_N *= std::exp(z[3]);
  rig.cylinder.friction.stribeck_N *= std::exp(z[4]);
  rig.cylinder.friction.viscous_N_s_m *= std::exp(z[5]);
  rig.cylinder.moving_mass_kg *= std::exp(z[6]);
  return rig;
}

ServoRun run(const ServoRig& rig, const ServoRecord& record, std::size_t samples) {
  const plant::ThinPlateValve port(rig.valve, rig.cylinder.gas);
  ServoCylinder cylinder(ValvePair(std::array<plant::ThinPlateValve, 2>{port, port}), rig.cylinder);
  ServoRun ran;
  for (auto* column : {&ran.positions_m, &ran.pressures_1_Pa, &ran.pressures_2_Pa}) column->reserve(samples);
  for (std::size_t k = 0; k < samples; ++k) {
    ran.positions_m.push_back(cylinder.position_m());
    ran.pressures_1_Pa.push_back(cylinder.pressure_Pa(0));
    ran.pressures_2_Pa.push_back(cylinder.pressure_Pa(1));
    cylinder.advance(plant::servo::five_three_commands_V(record.commands_V[k]), record.period_s);
  }
  return ran;
}

Eigen::VectorXd errors(const ServoRig& guess, const Variables& z, const ServoRecord& record,
                       std::size_t samples) {
  const std::vector<double> predicted = run(rig_at(guess, z), record, samples).positions_m;
  Eigen::VectorXd e(static_cast<Eigen::Index>(samples));
  for (std::size_t k = 0; k < samples; ++k)
    e[static_cast<Eigen::Index>(k)] = (predicted[k] - record.positions_m[k]) / kMillimetre;
  return e;
}

BoxGram<Eigen::Dynamic> gram(const ServoRig& guess, const Variables& z, const ServoRecord& record,
                             std::size_t samples, const PerFigure& held) {
  Eigen::MatrixXd J_e(static_cast<Eigen::Index>(samples), kFigures + 1);
  J_e.col(kFigures) = errors(guess, z, record, samples);
  for (int i = 0; i < kFigures; ++i) {
    if (held[static_cast<std::size_t>(i)]) {
      J_e.col(i).setZero();
      continue;
    }
    Variables moved = z;
    moved[i] += kStep;
    J_e.col(i) = (errors(guess, moved, record, samples) - J_e.col(kFigures)) / kStep;
  }
  return J_e.transpose() * J_e;
}

bool moves(const std::vector<double>& positions_m) {
  const auto [least, most] = std::minmax_element(positions_m.begin(), positions_m.end());
  return *most - *least >= kMillimetre;
}

void require_record(const ServoRecord& record) {
  if (record.commands_V.size() != record.positions_m.size() || record.commands_V.empty()) {
    throw std::invalid_argument(
        fmt::format("servo record: {} commands and {} positions, expected as many of each",
                    record.commands_V.size(), record.positions_m.size()));
  }
  if (!(record.period_s > 0.0))
    throw std::invalid_argument(fmt::format("servo record: period {} s, expected above 0", record.period_s));
  for (std::size_t k = 0; k < record.positions_m.size(); ++k) {
    if (!std::isfinite(record.positions_m[k]) || !std::isfinite(record.commands_V[k]))
      throw std::invalid_argument(fmt::format("servo record: row {} is not finite", k));
  }
  if (!moves(record.positions_m))
    throw CannotIdentify("servo record: the piston moves less than 1 mm, so nothing can be learnt from it");
}

}  // namespace

ServoRun free_run(const ServoRig& rig, const ServoRecord& record) {
  return run(rig, record, record.commands_V.size());
}

ServoFit fit_servo(const ServoRig& guess, const ServoRecord& record, const PerFigure& held,
                   const std::function<void(double)>& progress) {
  require_record(record);
  const std::size_t all = record.positions_m.size();
  if (!moves(run(guess, record, all).positions_m)) {
    throw CannotIdentify(
        "servo fit: the piston of the guess does not move, expected less friction, or a larger valve");
  }
  Variables bound = Variables::Constant(kFigures, std::log(kWidest));
  bound[kNull] = kWidestNull_V / kNullUnit_V;
  for (int i = 0; i < kFigures; ++i)
    if (held[static_cast<std::size_t>(i)]) bound[i] = 0.0;
  Variables z = Variables::Zero(kFigures);
  ServoFit fit;
  auto samples = std::min(all, static_cast<std::size_t>(kFirstHorizon_s / record.period_s) + 1);
  for (;;) {
    BoxProblem<Eigen::Dynamic> problem;
    problem.squares = [&](const Variables& at) { return errors(guess, at, record, samples).squaredNorm(); };
    problem.gram = [&](const Variables& at) { return gram(guess, at, record, samples, held); };
    problem.low = -bound;
    problem.high = bound;
    const auto solution = minimise_in_box<Eigen::Dynamic>(problem, z, kMostIterations, kTolerance);
    z = solution.z;
    fit.iterations += solution.iterations;
    if (progress) progress(static_cast<double>(samples) / static_cast<double>(all));
    if (samples == all) break;
    samples = kGrowth * samples >= all ? all : kGrowth * samples;
  }

  const BoxGram<Eigen::Dynamic> last = gram(guess, z, record, all, held);
  const double squares = last(kFigures, kFigures);
  Eigen::MatrixXd H = last.topLeftCorner(kFigures, kFigures);
  for (int i = 0; i < kFigures; ++i) {
    if (held[static_cast<std::size_t>(i)]) H(i, i) = 1.0;  // its row and column are 0
    if (!(H(i, i) > 0.0))
      throw CannotIdentify(fmt::format("servo fit: the recording does not show the {}",
                                       kFittedNames[static_cast<std::size_t>(i)]));
  }
  const Eigen::MatrixXd inverse = H.ldlt().solve(Eigen::MatrixXd::Identity(kFigures, kFigures));
  const double variance = squares / static_cast<double>(all);
  for (int i = 0; i < kFigures; ++i) {
    const auto figure = static_cast<std::size_t>(i);
    if (held[figure]) continue;
    // 1 / (H_ii H^-1_ii) is the share of a column's square that the others cannot imitate
    if (!(inverse(i, i) > 0.0) || 1.0 / (H(i, i) * inverse(i, i)) < 1e-10)
      throw CannotIdentify(
          fmt::format("servo fit: the recording cannot tell the {} from the others", kFittedNames[figure]));
    const double unit = i == kNull ? kNullUnit_V : 1.0;
    fit.error[figure] = unit * std::sqrt(variance * inverse(i, i));
    fit.at_bound[figure] = std::abs(z[i]) >= bound[i] * (1.0 - 1e-9);
  }
  fit.rig = rig_at(guess, z);
  fit.rms_m = kMillimetre * std::sqrt(variance);
  return fit;
}

}  // namespace plenum::host::identify::servo
