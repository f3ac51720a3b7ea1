// The greater of two numbers, for a largest error that must not lose one that is none.
#pragma once

#include <cmath>

namespace plenum::host::identify::relief_valve {

/// NaN where either is one, unlike std::max.
inline double greater_of(double a, double b) {
  return std::isnan(a) || a >= b ? a : b;
}

}  // namespace plenum::host::identify::relief_valve
