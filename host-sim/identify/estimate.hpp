// What a fit within bounds says of one figure.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace plenum::host::identify {

enum class Bound { none, low, high };

struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;  ///< NaN at a bound, and where the figure was held
  Bound at_bound = Bound::none;
};

/// What a model file says of it beside the value: "standard_error", null where it is no number, and "at_bound", "low", "high" or
/// null.
nlohmann::ordered_json to_json(const Estimate& of);

/// A figure is at a bound when it is nearer than a millionth of the range; a range without width holds it, which is no bound.
Bound bound_of(double value, double low, double high);

/// "at its lower bound"; empty for none.
const char* bound_in_words(Bound bound);

}  // namespace plenum::host::identify
