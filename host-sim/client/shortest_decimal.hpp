// A float as a person writes it.
#pragma once

namespace plenum::host::client {

/// The shortest decimal of the float, or its exact value where rounding twice would miss the float.
double shortest_decimal(float value);

}  // namespace plenum::host::client
