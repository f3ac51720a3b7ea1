// The figures of a valve that a calibration fits: as a rig file names them, in the order of effects::Figures.
#pragma once

#include <array>

#include "host-sim/effects/catalogue.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::identify::chamber {

struct ValveFigure {
  const char* name;
  double trace::RigDescription::Valve::*member;
};

/// By enumerator (effects::kOpenAbove ..).
inline constexpr std::array<ValveFigure, effects::kValveFigures> kValveFigures = [] {
  using Valve = trace::RigDescription::Valve;
  std::array<ValveFigure, effects::kValveFigures> figures{};
  figures[effects::kOpenAbove] = {"open_above_V", &Valve::open_above_V};
  figures[effects::kExhaustBelow] = {"exhaust_below_V", &Valve::exhaust_below_V};
  figures[effects::kInletGain] = {"inlet_area_per_V_m2", &Valve::inlet_area_per_V_m2};
  figures[effects::kExhaustGain] = {"exhaust_area_per_V_m2", &Valve::exhaust_area_per_V_m2};
  figures[effects::kInletLeak] = {"inlet_leak_m2", &Valve::inlet_leak_m2};
  figures[effects::kExhaustLeak] = {"exhaust_leak_m2", &Valve::exhaust_leak_m2};
  figures[effects::kTransition] = {"transition_m2", &Valve::transition_m2};
  return figures;
}();

}  // namespace plenum::host::identify::chamber
