// "Modeling and Identification of Pneumatic Actuators": its equations, tables and figures beside ours.
#pragma once

#include <vector>

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::actuators {

/// All parts, in the paper's order. About 10 s on one processor, nearly all of it the 152 fits of Fig. 11 to
/// 13.
std::vector<Part> reproduce_actuators(const Progress& progress);

}  // namespace plenum::host::reproduce::actuators
