// What any ordered number has, and what decay() and parts() of every type agree on. Of not-a-number min and max answer with
// their first operand, clamp with not-a-number.
#pragma once

namespace plenum::numeric {

template <class Real>
constexpr Real abs(Real x) noexcept {
  return x < Real(0) ? -x : x;
}
template <class Real>
constexpr Real min(Real a, Real b) noexcept {
  return b < a ? b : a;
}
template <class Real>
constexpr Real max(Real a, Real b) noexcept {
  return a < b ? b : a;
}
template <class Real>
constexpr Real clamp(Real x, Real low, Real high) noexcept {
  return min(max(x, low), high);
}

/// A positive number as mantissa 2^exponent, mantissa from sqrt(1/2) to sqrt(2).
template <class Real>
struct Parts {
  Real mantissa;
  int exponent;
};

/// Where a decay has reached its end: e^-24 is less than half a unit in the last place of 1, in float as in Q31.32.
inline constexpr int kDecayHigh = 24;
/// Growth is followed up to this exponent: e^4 is 55.
inline constexpr int kGrowthHigh = 4;

}  // namespace plenum::numeric
