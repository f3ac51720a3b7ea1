// Effects and their parameters as a rig's description names them, in the units that the catalogue states with each
// parameter's name (catalogue.hpp, which cites each effect's source).
#pragma once

#include <map>
#include <string>

#include "host-sim/effects/catalogue.hpp"

namespace plenum::host::effects {

/// Which effects are on, and with which figures; those of the valve are the chamber's.
struct ChamberEffects {
  EffectSet on = 0;
  Figures figures = neutral_figures();
};

/// Effects by id, figures by the name of their parameter and in its unit; a parameter left out has the value at which it
/// vanishes. Throws std::invalid_argument for an id or a name that the catalogue does not have, with those there are,
/// and for a value out of its bounds.
ChamberEffects chamber_effects(const std::map<std::string, std::map<std::string, double>>& wanted);

}  // namespace plenum::host::effects
