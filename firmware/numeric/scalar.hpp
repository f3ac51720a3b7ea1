// The scalar of the control core, chosen at build time, and the few functions of it that the core needs.
//
// All of firmware/control computes in Scalar; no file there names float or double. The functions below are
// the whole vocabulary: a fixed-point type that supplies them drops in without a change to a controller.
//
// No function here calls the C library: its expf differs between machines in the last bit (and picks fused
// multiply-add where the processor has it), and the core promises the same bits everywhere.
#pragma once

#include <bit>
#include <cstdint>

namespace plenum::numeric {

using Scalar = float;

/// Square root, correctly rounded (IEEE 754). x >= 0.
inline Scalar sqrt(Scalar x) noexcept {
  return __builtin_sqrtf(x);
}

constexpr Scalar abs(Scalar x) noexcept {
  return x < Scalar(0) ? -x : x;
}
constexpr Scalar min(Scalar a, Scalar b) noexcept {
  return b < a ? b : a;
}
constexpr Scalar max(Scalar a, Scalar b) noexcept {
  return a < b ? b : a;
}
constexpr Scalar clamp(Scalar x, Scalar low, Scalar high) noexcept {
  return min(max(x, low), high);
}

/// True for a number, false for infinities and not-a-number.
constexpr bool is_finite(Scalar x) noexcept {
  return x - x == Scalar(0);
}

/// Above this exponent a decay has reached its end: e^-24 is less than half a unit in the last place of 1.
inline constexpr Scalar kDecayHigh = Scalar(24);

/// The part of a first-order response that is done after the dimensionless time x >= 0: 1 - e^-x.
///
/// x is clamped to [0, kDecayHigh]: time does not run backwards, and a negative x gives 0. Relative error
/// below 3e-7, also for x near 0, where 1 - expf(-x) would cancel. Method: -x = n ln2 + f with |f| <= ln2/2,
/// e^f - 1 by its Taylor polynomial of degree 7 (remainder f^8/8! < 6e-9 of f), and e^-x - 1 = 2^n (e^f - 1)
/// + (2^n - 1), exact in its last term. No branch, so that a loop over an array of x vectorises.
inline Scalar decay(Scalar x) noexcept {
  const Scalar y = -clamp(x, Scalar(0), kDecayHigh);
  constexpr Scalar kLog2e = 1.44269504F;
  constexpr Scalar kLn2High =
      0.693359375F;  // exact in 10 bits: n * kLn2High has no rounding error for |n| < 2^14
  constexpr Scalar kLn2Low = -2.12194440e-4F;
  constexpr Scalar kShift = 64.5F;  // makes the truncation below a rounding to nearest
  const std::int32_t n = static_cast<std::int32_t>(y * kLog2e + kShift) - 64;
  const Scalar power = static_cast<Scalar>(n);
  const Scalar f = (y - power * kLn2High) - power * kLn2Low;
  Scalar q = Scalar(1.0 / 5040);
  q = q * f + Scalar(1.0 / 720);
  q = q * f + Scalar(1.0 / 120);
  q = q * f + Scalar(1.0 / 24);
  q = q * f + Scalar(1.0 / 6);
  q = q * f + Scalar(1.0 / 2);
  q = q * f + Scalar(1);
  const Scalar two_to_n = std::bit_cast<Scalar>((n + 127) << 23);
  return -(two_to_n * (q * f) + (two_to_n - Scalar(1)));
}

/// The mean over [0, x] of e^-t, that is (1 - e^-x)/x, given `done` = decay(x); 1 at x = 0.
///
/// A negative x counts as 0. For x < 2^-7 the series 1 - x/2 + x^2/6 (remainder x^3/24 < 2e-8) stands for the
/// quotient. No branch.
inline Scalar mean_decay(Scalar x, Scalar done) noexcept {
  constexpr Scalar kSmall = Scalar(0.0078125);
  const Scalar clamped = max(x, Scalar(0));
  const Scalar series = Scalar(1) - clamped * (Scalar(0.5) - clamped * Scalar(1.0 / 6));
  const Scalar quotient = done / max(clamped, kSmall);
  return clamped < kSmall ? series : quotient;
}

/// Natural logarithm of a normal x > 0; absolute error below 2e-7 + 6e-8 |ln x|.
///
/// Method: x = m 2^n with m in [sqrt(1/2), sqrt(2)); ln m = 2 artanh((m - 1)/(m + 1)) by its series to the ninth power
/// (remainder below 4e-10).
inline Scalar log(Scalar x) noexcept {
  constexpr Scalar kLn2 = 0.693147181F;
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t n = (bits - 0x3F3504F3) >> 23;  // 3F3504F3h is sqrt(1/2)
  const Scalar m = std::bit_cast<Scalar>(bits - n * (1 << 23));
  const Scalar s = (m - Scalar(1)) / (m + Scalar(1));
  const Scalar s2 = s * s;
  Scalar q = Scalar(2.0 / 9);
  q = q * s2 + Scalar(2.0 / 7);
  q = q * s2 + Scalar(2.0 / 5);
  q = q * s2 + Scalar(2.0 / 3);
  q = q * s2 + Scalar(2);
  return q * s + static_cast<Scalar>(n) * kLn2;
}

/// x^exponent for 0 < x <= 1 and exponent >= 0; relative error below 1e-6 where the result is above 1e-4.
inline Scalar power(Scalar x, Scalar exponent) noexcept {
  return Scalar(1) - decay(-exponent * log(x));
}

/// Growth is followed up to this exponent: e^4 is 55.
inline constexpr Scalar kGrowthHigh = Scalar(4);

/// (1 - e^-x)/x for x of either sign, 1 at x = 0; x below -kGrowthHigh counts as that. No branch.
inline Scalar phi_1(Scalar x) noexcept {
  const bool falls = x >= Scalar(0);
  const Scalar y = falls ? x : min(-x, kGrowthHigh);
  const Scalar done = decay(y);
  // of a growth (e^y - 1)/y, e^-y - 1 = -done
  return mean_decay(y, done) / (falls ? Scalar(1) : Scalar(1) - done);
}

/// (1 - phi_1(x))/x, 1/2 at x = 0, given phi_1(x).
inline Scalar phi_2(Scalar x, Scalar phi_1_of_x) noexcept {
  if (abs(x) < Scalar(0.0625)) {
    return Scalar(0.5) - x * (Scalar(1.0 / 6) - x * (Scalar(1.0 / 24) - x * Scalar(1.0 / 120)));
  }
  return (Scalar(1) - phi_1_of_x) / max(x, -kGrowthHigh);
}

}  // namespace plenum::numeric
