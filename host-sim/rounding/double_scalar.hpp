// double as a scalar of the core, from the C library: what the board's are compared with. Included before everything else where the
// core is compiled for it.
#pragma once

#include <cmath>

#include "firmware/numeric/order.hpp"

#define PLENUM_SCALAR_TYPE double

namespace plenum::numeric {

inline double sqrt(double x) noexcept {
  return std::sqrt(x);
}
inline double near_ratio(double a, double b) {
  return a / b;
}
inline double inverse_sqrt(double x) noexcept {
  return 1.0 / std::sqrt(x);
}
inline bool is_finite(double x) noexcept {
  return std::isfinite(x);
}
inline double decay(double x) noexcept {
  return -std::expm1(-clamp(x, 0.0, double{kDecayHigh}));
}
inline Parts<double> parts(double x) noexcept {
  int exponent = 0;
  const double half = std::frexp(x, &exponent);  // 1/2 to 1
  return half < std::sqrt(0.5) ? Parts<double>{2 * half, exponent - 1} : Parts<double>{half, exponent};
}

}  // namespace plenum::numeric
