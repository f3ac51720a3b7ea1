#include "host-sim/identify/estimate.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace plenum::host::identify {

nlohmann::ordered_json to_json(const Estimate& of) {
  using Json = nlohmann::ordered_json;
  return {{"standard_error", std::isfinite(of.standard_error) ? Json(of.standard_error) : Json(nullptr)},
          {"at_bound", of.at_bound == Bound::none  ? Json(nullptr)
                       : of.at_bound == Bound::low ? Json("low")
                                                   : Json("high")}};
}

Bound bound_of(double value, double low, double high) {
  if (low == high) return Bound::none;
  const double margin = 1e-6 * (high - low);
  if (value - low < margin) return Bound::low;
  return high - value < margin ? Bound::high : Bound::none;
}

const char* bound_in_words(Bound bound) {
  switch (bound) {
    case Bound::none:
      break;
    case Bound::low:
      return "at its lower bound";
    case Bound::high:
      return "at its upper bound";
  }
  return "";
}

}  // namespace plenum::host::identify
