// Models drawn from all that an image may carry: every parameter from its schema's range, the whole set by validate().
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <span>

#include "firmware/config/model_image.hpp"

namespace plenum::control::testing {

/// A parameter between its bounds: such a share of the draws is a bound. A range that spans decades is drawn by its logarithm, to either side of
/// zero where zero lies within.
template <class Random>
float draw_within(Random& random, const config::ParameterSpec& spec, double at_a_bound) {
  constexpr double kDecades = 6;  // that a magnitude may lie below the farther bound
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  if (unit(random) < at_a_bound) return unit(random) < 0.5 ? spec.low : spec.high;
  const auto low = static_cast<double>(spec.low), high = static_cast<double>(spec.high);
  double drawn = 0;
  if (low > 0 && high / low <= 100) {
    drawn = low + (high - low) * unit(random);
  } else if (low > 0) {
    drawn = low * std::pow(high / low, unit(random));
  } else {
    const bool below = unit(random) * (high - low) < -low;
    drawn = (below ? low : high) * std::pow(10.0, -kDecades * unit(random));
  }
  return std::clamp(static_cast<float>(drawn), spec.low, spec.high);
}

/// Drawn until validate() accepts it.
template <class Random>
config::ModelParameters draw_admissible(Random& random, config::ModelKind kind, double at_a_bound = 0.1) {
  const std::span schema = config::parameter_schema(kind);
  config::ModelParameters model;
  model.kind = kind;
  model.count = static_cast<std::uint16_t>(schema.size());
  do {
    for (std::size_t i = 0; i < schema.size(); ++i)
      model.value[i] = draw_within(random, schema[i], at_a_bound);
  } while (!config::validate(model));
  return model;
}

}  // namespace plenum::control::testing
