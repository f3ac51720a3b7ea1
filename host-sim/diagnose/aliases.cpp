#include "host-sim/diagnose/aliases.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>

namespace plenum::host::diagnose {
namespace {

using effects::kCatalogue;
using effects::kEffects;
using effects::kLanes;
using identify::chamber::Record;
using identify::chamber::Variable;

/// Of a parameter's typical change: a size at which the readings are linear in it.
constexpr double kSmall = 0.1;
/// Of a scaled figure of the valve; of a start pressure [Pa].
constexpr double kStep = 1e-3;
constexpr double kStart_Pa = 100.0;
/// Shares of the squares: what calibration leaves of an effect that it takes up, and what parts two that are one.
constexpr double kTakenUp = 1e-4;
constexpr double kParted = 0.01;

/// Sensitivities of a record's fitted readings: valve, start, effects.
Eigen::MatrixXd sensitivities(const Scene& scene, const Record& record, const effects::Figures& figures,
                              const effects::Start& start) {
  struct Change {
    effects::Run run;
    effects::EffectSet on = 0;
  };
  std::vector<Change> changes;
  for (const Variable& v : valve_variables(scene)) {
    Change change{{figures, start}};
    change.run.figures[v.figure] +=
        kStep * v.scale * (figures[v.figure] < v.high - kStep * v.scale ? 1.0 : -1.0);
    changes.push_back(change);
  }
  changes.push_back({{figures, {start.pressure_Pa + kStart_Pa, start.warmth_Pa}}});
  for (std::size_t i = 0; i < kEffects; ++i) {
    const effects::Parameter p = kCatalogue[i]->parameters.front().of(size_of(scene));
    Change change{{figures, start}, effects::EffectSet{1} << i};
    double& at = change.run.figures[effects::kFirstFigure[i]];
    at += kSmall * p.typical_change * (at + kSmall * p.typical_change <= p.greatest() ? 1.0 : -1.0);
    changes.push_back(change);
  }
  const auto settled = static_cast<Eigen::Index>(record.settled_rows);
  const auto rows = static_cast<Eigen::Index>(record.fitted_rows) - settled;
  Eigen::MatrixXd table(rows, static_cast<Eigen::Index>(changes.size()));
  std::vector<double> lanes(record.fitted_rows * static_cast<std::size_t>(kLanes));
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const std::array<effects::Run, 2> runs{{{figures, start}, changes[k].run}};
    effects::free_run(scene.around, record.drive, changes[k].on | scene.known, runs, lanes);
    for (Eigen::Index row = 0; row < rows; ++row) {
      const double* at = lanes.data() + (row + settled) * kLanes;
      table(row, static_cast<Eigen::Index>(k)) = at[1] - at[0];
    }
  }
  return table;
}

}  // namespace

std::vector<std::vector<std::string>> alias_classes(const Scene& scene, const effects::Figures& figures,
                                                    const std::vector<effects::Start>& start) {
  constexpr Eigen::Index kValve = effects::kValveFigures;
  constexpr auto kHypotheses = static_cast<Eigen::Index>(kEffects);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(kHypotheses, kHypotheses);  // before calibration
  Eigen::MatrixXd valve = Eigen::MatrixXd::Zero(kValve, kValve);
  Eigen::MatrixXd across = Eigen::MatrixXd::Zero(kValve, kHypotheses);
  for (std::size_t r = 0; r < scene.records.size(); ++r) {
    Eigen::MatrixXd table = sensitivities(scene, scene.records[r], figures, start[r]);
    // each record has a start pressure of its own
    const Eigen::VectorXd by_start = table.col(kValve).normalized();
    table -= by_start * (by_start.transpose() * table);
    valve += table.leftCols(kValve).transpose() * table.leftCols(kValve);
    if (scene.records[r].before) continue;  // no effect acts there, but it holds the valve's figures
    all += table.rightCols(kHypotheses).transpose() * table.rightCols(kHypotheses);
    across += table.leftCols(kValve).transpose() * table.rightCols(kHypotheses);
  }
  const Eigen::VectorXd unit = valve.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  valve = unit.asDiagonal() * valve * unit.asDiagonal();
  valve.diagonal().array() += 1e-10;
  across = unit.asDiagonal() * across;
  const Eigen::MatrixXd left = all - across.transpose() * valve.ldlt().solve(across);

  std::vector<std::string> taken_up{"calibration"};
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < kEffects; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (left(at, at) > kTakenUp * all(at, at)) {
      seen.push_back(i);
    } else if (all(at, at) > 0.0) {
      taken_up.emplace_back(kCatalogue[i]->id);
    }
  }
  std::vector<std::vector<std::string>> classes;
  if (taken_up.size() > 1) classes.push_back(taken_up);
  while (!seen.empty()) {
    const auto first = static_cast<Eigen::Index>(seen.front());
    std::vector<std::string> alike;
    std::erase_if(seen, [&](std::size_t i) {
      const auto at = static_cast<Eigen::Index>(i);
      const double cosine2 = left(first, at) * left(first, at) / (left(first, first) * left(at, at));
      if (cosine2 < 1.0 - kParted) return false;
      alike.emplace_back(kCatalogue[i]->id);
      return true;
    });
    if (alike.size() > 1) classes.push_back(std::move(alike));
  }
  return classes;
}

}  // namespace plenum::host::diagnose
