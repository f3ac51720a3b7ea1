// The papers that Plenum stands on, in the order in which it counts them.
#pragma once

#include <span>

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce {

std::span<const Paper> papers();

}  // namespace plenum::host::reproduce
