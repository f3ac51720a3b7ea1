// "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve Model", part by
// part.
#pragma once

#include <vector>

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::proportional_valve {

/// Takes about 5 s: 104 set points, measured and fitted without and with the spool's lag.
std::vector<Part> reproduce_proportional_valve(const Progress& progress);

}  // namespace plenum::host::reproduce::proportional_valve
