// The root of a continuous function between two arguments of opposite sign, by halving: sure, and fast enough
// where it is not an inner loop. Argument and function are in the caller's units. Source: the bisection method, e.g.
// Press et al., Numerical Recipes (2007), 9.1.
#pragma once

#include <cmath>

namespace plenum::host::plant {

/// Argument where `f` changes sign, to the last bits of a double; f(low) and f(high) differ in sign or one is
/// 0.
template <typename Function>
double root_between(const Function& f, double low, double high) {
  const bool rises = f(high) > 0.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    ((f(middle) > 0.0) == rises ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace plenum::host::plant
