#include "host-sim/diagnose/estimates.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "host-sim/identify/chamber/valve_figures.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::kCatalogue;
using effects::kEffects;
using identify::chamber::kKnot;
using identify::chamber::kValveFigures;
using identify::chamber::Variable;

const effects::Parameter& parameter_of(std::size_t figure) {
  for (std::size_t i = 0; i < kEffects; ++i) {
    const std::size_t first = effects::kFirstFigure[i];
    if (figure >= first && figure < effects::kFirstFigure[i + 1])
      return kCatalogue[i]->parameters[figure - first];
  }
  throw std::logic_error("a figure of valve or log is no effect's");
}

}  // namespace

Estimate estimate_of(const Fit& fit, std::size_t variable, const Eigen::VectorXd& errors) {
  constexpr double k95 = 1.96;
  const Variable& v = fit.variables[variable];
  const double at = fit.figures[v.figure];
  const double half = k95 * v.scale * errors[static_cast<Eigen::Index>(variable)];
  const double low = std::max(at - half, v.low);
  const double high = std::min(at + half, v.high);
  const double room = 1e-6 * (v.high - v.low);
  const bool at_bound = at - v.low < room || v.high - at < room;
  if (v.figure < effects::kValveFigures) return {kValveFigures[v.figure].name, at, low, high, at_bound};
  const effects::Parameter& p = parameter_of(v.figure);
  const double a = p.value_of(low);
  const double b = p.value_of(high);
  return {std::string(p.name), p.value_of(at), std::min(a, b), std::max(a, b), at_bound};
}

std::vector<Estimate> parameters_of(const Trial& trial, std::size_t effect, double correlated_rows) {
  const Eigen::VectorXd errors = standard_errors(trial.fit, correlated_rows);
  std::vector<Estimate> estimates;
  for (std::size_t i = 0; i < trial.fit.variables.size(); ++i) {
    const std::size_t figure = trial.fit.variables[i].figure;
    if (figure >= effects::kFirstFigure[effect] && figure < effects::kFirstFigure[effect + 1]) {
      estimates.push_back(estimate_of(trial.fit, i, errors));
    }
  }
  if (effect == effects::kIdNullDrift && wanders(trial.fit)) {
    // of what the spline's figures are coefficients
    const double knot_s = trial.fit.figures[kKnot];
    estimates.push_back({std::string(parameter_of(kKnot).name), knot_s, knot_s, knot_s, false});
  }
  return estimates;
}

}  // namespace plenum::host::diagnose
