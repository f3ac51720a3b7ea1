#include "host-sim/diagnose/found_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "host-sim/identify/chamber/valve_figures.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::kValveFigures;
using identify::chamber::ValveFigure;
double to_six_digits(double value) {
  return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

}  // namespace

std::vector<NamedEffect> effects_in_model(const GapReport& report) {
  std::vector<NamedEffect> chosen;
  for (const NamedEffect& one : report.effects) {
    const bool rival = std::any_of(chosen.begin(), chosen.end(), [&](const NamedEffect& other) {
      return std::find(other.aliases.begin(), other.aliases.end(), one.id) != other.aliases.end();
    });
    if (!rival) chosen.push_back(one);
  }
  return chosen;
}

trace::RigDescription found_rig(trace::RigDescription rig, const GapReport& report) {
  for (const ValveFigure& figure : kValveFigures) {
    const auto of = std::find_if(report.calibration.begin(), report.calibration.end(),
                                 [&](const auto& one) { return one.name == figure.name; });
    if (of == report.calibration.end()) continue;
    rig.valve.*figure.member = to_six_digits(report.effects.empty() ? of->fitted.value : of->with_effects);
  }
  for (const NamedEffect& one : effects_in_model(report)) {
    auto& figures = rig.effects[one.id];
    for (const Estimate& parameter : one.parameters) {
      if (std::isfinite(parameter.value)) {
        figures[parameter.name] = to_six_digits(parameter.value);
      } else {
        figures.erase(parameter.name);  // what a rig does not say is infinite
      }
    }
  }
  return rig;
}

}  // namespace plenum::host::diagnose
