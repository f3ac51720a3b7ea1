// "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve Model", part by
// part.
#pragma once

#include <vector>

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::proportional_valve {

/// Takes about 10 s: 104 set points, measured and fitted on four rigs.
std::vector<Part> reproduce_proportional_valve(const Progress& progress);

}  // namespace plenum::host::reproduce::proportional_valve
