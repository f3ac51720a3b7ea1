// Refusal of a value out of its range: one line naming the field, what was found and what was expected.
#pragma once

#include <string_view>

namespace plenum::host::plant {

/// Throws std::invalid_argument "<field>: <value>, expected ..." unless `value` is finite and holds the
/// bound.
void require_finite(std::string_view field, double value);
void require_above(std::string_view field, double value, double bound);
void require_within(std::string_view field, double value, double low, double high);

}  // namespace plenum::host::plant
