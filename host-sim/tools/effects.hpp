// The catalogue of effects, as a command line speaks of it.
#pragma once

#include <string_view>

#include "host-sim/effects/catalogue.hpp"

namespace plenum::host::tools {

/// The effect of this id. Throws trace::InputError, which begins with `where` and lists the ids there are.
const effects::Effect& effect_of(std::string_view id, std::string_view where);

}  // namespace plenum::host::tools
