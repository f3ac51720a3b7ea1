// "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems": its equations and
// figures beside ours.
#pragma once

#include <vector>

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::servo {

/// All parts, in the paper's order. About 5 s on one processor, nearly all of it the free-run fit and the
/// training.
std::vector<Part> reproduce_servo(const Progress& progress);

}  // namespace plenum::host::reproduce::servo
