// A random admissible parameter set of all that an image may carry: each parameter at either end of its range as often as somewhere
// within.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "firmware/config/model_image.hpp"

namespace ranges {

template <class Random>
plenum::config::ModelParameters admissible_set(Random& random, plenum::config::ModelKind kind) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const auto one_in = [&](int n) { return share(random) * n < 1; };
  const auto parameter = [&](double low, double high) {
    if (one_in(5)) return low;
    if (one_in(4)) return high;
    if (high <= 0 || one_in(2)) return low + (high - low) * share(random);
    const double least = std::max(low, 1e-4 * high);
    return least * std::pow(high / least, share(random));
  };
  plenum::config::ModelParameters set;
  set.kind = kind;
  do {
    set.count = 0;
    for (const plenum::config::ParameterSpec& one : plenum::config::parameter_schema(kind)) {
      const double x = parameter(static_cast<double>(one.low), static_cast<double>(one.high));
      set.value[set.count++] = std::clamp(static_cast<float>(x), one.low, one.high);
    }
  } while (!plenum::config::validate(set));
  return set;
}

}  // namespace ranges
