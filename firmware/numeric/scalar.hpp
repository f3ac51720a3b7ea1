// The scalar of the control core, chosen at build time (-DPLENUM_SCALAR=float or fixed), and the few functions of it that the
// core needs.
//
// All of firmware/control computes in Scalar; no file there names float. A type that supplies sqrt, decay, parts, thousandth and
// is_finite (float_scalar.hpp, fixed_scalar.hpp), and a nearest_within (nearest.hpp), drops in without a change to a controller.
//
// No function here calls the C library: its expf differs between machines in the last bit (and picks fused
// multiply-add where the processor has it), and the core promises the same bits everywhere.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <type_traits>

#include "firmware/numeric/fixed_scalar.hpp"
#include "firmware/numeric/float_scalar.hpp"
#include "firmware/numeric/order.hpp"

namespace plenum::numeric {

#if defined(PLENUM_SCALAR_FIXED)
using Scalar = Fixed;
#elif defined(PLENUM_SCALAR_TYPE)  // a test's own
using Scalar = PLENUM_SCALAR_TYPE;
#else
using Scalar = float;
#endif

/// What the functions below take.
template <class Real>
concept Number = std::same_as<Real, float> || std::same_as<Real, Fixed> || std::same_as<Real, Scalar>;

/// How many numbers a processor may compute with side by side: vectors of four, but of integers of 64 bits none.
inline constexpr std::size_t kLanes = std::same_as<Scalar, Fixed> ? 1 : 4;

/// What holds a part of a whole, from 0 to 1.
template <Number Real>
using PartOf = std::conditional_t<std::same_as<Real, Fixed>, Fraction, Real>;

/// x 2^-kBits.
template <int kBits, Number Real>
constexpr Real shifted_down(Real x) noexcept {
  return x * Real(1.0F / static_cast<float>(1U << kBits));
}

/// a/b and a b for where a search looks next: of a fixed-point number no further than 2^bits from 0, and not counted as cut off there.
template <int bits, Number Real>
constexpr Real ratio_within(Real a, Real b) noexcept {
  return a / b;
}
template <int bits, Number Real>
constexpr Real product_within(Real a, Real b) noexcept {
  return a * b;
}

/// decay(x), and what a part leaves of the whole.
template <Number Real>
inline Real decay_part(Real x) noexcept {
  return decay(x);
}
template <Number Real>
inline Real rest_of(Real part) noexcept {
  return Real(1) - part;
}

/// The whole of which part_of() gives the parts: of numbers up to x. A number that is its own part needs none.
template <Number Real>
constexpr Real whole_above(Real /*x*/) noexcept {
  return Real(1);
}
template <Number Real>
constexpr Real part_of(Real x, Real /*whole*/) noexcept {
  return x;
}

/// done = decay(gain k + shift) for many k.
template <Number Real, std::size_t kCount>
inline void decays(Real gain, Real shift, const std::array<Real, kCount>& k,
                   std::array<Real, kCount>& done) noexcept {
  for (std::size_t i = 0; i < kCount; ++i) done[i] = decay(gain * k[i] + shift);
}

/// share = (of + shift) part - less for many.
template <Number Real, std::size_t kCount>
inline void shares(const std::array<Real, kCount>& of, Real shift, const std::array<Real, kCount>& part,
                   Real less, std::array<Real, kCount>& share) noexcept {
  for (std::size_t i = 0; i < kCount; ++i) share[i] = (of[i] + shift) * part[i] - less;
}

/// The mean over [0, x] of e^-t, that is (1 - e^-x)/x, given `done` = decay(x); 1 at x = 0.
///
/// A negative x counts as 0. For x < 2^-7 the series 1 - x/2 + x^2/6 (remainder x^3/24 < 2e-8) stands for the
/// quotient.
template <Number Real>
inline Real mean_decay(Real x, Real done) noexcept {
  if (x >= Real(0.0078125)) return done / x;
  const Real clamped = max(x, Real(0));
  return Real(1) - clamped * (Real(0.5) - clamped * Real(1.0 / 6));
}

/// Natural logarithm of a normal x > 0; absolute error below 2e-7 + 6e-8 |ln x| in float, 2e-9 + 3e-10 |ln x| in Q31.32.
///
/// Method: x = m 2^n with m in [sqrt(1/2), sqrt(2)); ln m = 2 artanh((m - 1)/(m + 1)) by its series to the ninth power
/// (remainder below 4e-10).
template <Number Real>
inline Real log(Real x) noexcept {
  constexpr Real kLn2 = Real(0.69314718055994531);
  const auto [m, n] = parts(x);
  const Real s = (m - Real(1)) / (m + Real(1));
  const Real s2 = s * s;
  Real q = Real(2.0 / 9);
  q = q * s2 + Real(2.0 / 7);
  q = q * s2 + Real(2.0 / 5);
  q = q * s2 + Real(2.0 / 3);
  q = q * s2 + Real(2);
  return q * s + static_cast<Real>(n) * kLn2;
}

/// x^exponent for 0 < x <= 1 and exponent >= 0; relative error below 1e-6 where the result is above 1e-4.
template <Number Real>
inline Real power(Real x, Real exponent) noexcept {
  return Real(1) - decay(-exponent * log(x));
}

/// (1 - e^-x)/x for x of either sign, 1 at x = 0; x below -kGrowthHigh counts as that.
template <Number Real>
inline Real phi_1(Real x) noexcept {
  const bool falls = x >= Real(0);
  const Real y = falls ? x : min(-x, Real(kGrowthHigh));
  const Real done = decay(y);
  // of a growth (e^y - 1)/y, e^-y - 1 = -done
  return mean_decay(y, done) / (falls ? Real(1) : Real(1) - done);
}

/// (1 - phi_1(x))/x, 1/2 at x = 0, given phi_1(x).
template <Number Real>
inline Real phi_2(Real x, Real phi_1_of_x) noexcept {
  if (abs(x) < Real(0.0625)) {
    return Real(0.5) - x * (Real(1.0 / 6) - x * (Real(1.0 / 24) - x * Real(1.0 / 120)));
  }
  return (Real(1) - phi_1_of_x) / max(x, Real(-kGrowthHigh));
}

}  // namespace plenum::numeric
