// "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and Particle Swarm
// Optimization Methods": its equations, tables and figures beside ours.
#pragma once

#include <vector>

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::regulator_valve {

/// All parts, in the paper's order. About 4 s of processor time, nearly all of it swarms and staircases.
std::vector<Part> reproduce_regulator_valve(const Progress& progress);

}  // namespace plenum::host::reproduce::regulator_valve
