// What a short fit is of, that shows whether a longer one is worth it.
#pragma once

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

/// The first `seconds` of the same logs, in half as many steps a tick.
identify::chamber::Scene coarse(const identify::chamber::Scene& scene, double seconds);

}  // namespace plenum::host::diagnose
