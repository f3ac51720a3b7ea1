// "Grey-Box Multi-Port Models of Fluid Power Valves": its equations, tables and figures beside ours.
#pragma once

#include <vector>

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::relief_valve {

/// All parts, in the paper's order. Below a second on one processor.
std::vector<Part> reproduce_relief_valve(const Progress& progress);

}  // namespace plenum::host::reproduce::relief_valve
