// float as a scalar of the core (scalar.hpp): what is made of its bits.
#pragma once

#include <bit>
#include <cstdint>

#include "firmware/numeric/order.hpp"

namespace plenum::numeric {

/// Square root, correctly rounded (IEEE 754). x >= 0.
inline float sqrt(float x) noexcept {
  return __builtin_sqrtf(x);
}

/// 1/sqrt(x) of x > 0.
inline float inverse_sqrt(float x) noexcept {
  return 1.0F / sqrt(x);
}

/// a/b of b > 0.
constexpr float near_ratio(float a, float b) noexcept {
  return a / b;
}

/// x/1000, correctly rounded.
constexpr float thousandth(float x) noexcept {
  return x / 1000.0F;
}

/// True for a number, false for infinities and not-a-number.
constexpr bool is_finite(float x) noexcept {
  constexpr std::uint32_t kExponent = 0x7F800000U;
  return (std::bit_cast<std::uint32_t>(x) & kExponent) != kExponent;
}

/// 1 - e^-x for x clamped to [0, kDecayHigh]; relative error below 3e-7, also for x near 0, where 1 - expf(-x) would cancel.
/// 0 of not-a-number, whose conversion to an integer would be undefined.
///
/// Method: -x = n ln2 + f with |f| <= ln2/2, e^f - 1 by its Taylor polynomial of degree 7 (remainder f^8/8! < 6e-9 of f), and
/// e^-x - 1 = 2^n (e^f - 1) + (2^n - 1), exact in its last term. No branch, so that a loop over an array of x vectorises.
inline float decay(float x) noexcept {
  const float y = -min(max(0.0F, x), float{kDecayHigh});
  constexpr float kLog2e = 1.44269504F;
  constexpr float kLn2High =
      0.693359375F;  // exact in 10 bits: n * kLn2High has no rounding error for |n| < 2^14
  constexpr float kLn2Low = -2.12194440e-4F;
  constexpr float kShift = 64.5F;  // makes the truncation below a rounding to nearest
  const std::int32_t n = static_cast<std::int32_t>(y * kLog2e + kShift) - 64;
  const float power = static_cast<float>(n);
  const float f = (y - power * kLn2High) - power * kLn2Low;
  float q = 1.0F / 5040.0F;
  q = q * f + 1.0F / 720.0F;
  q = q * f + 1.0F / 120.0F;
  q = q * f + 1.0F / 24.0F;
  q = q * f + 1.0F / 6.0F;
  q = q * f + 1.0F / 2.0F;
  q = q * f + 1.0F;
  const float two_to_n = std::bit_cast<float>((n + 127) << 23);
  return -(two_to_n * (q * f) + (two_to_n - 1.0F));
}

/// Of a normal x > 0.
constexpr Parts<float> parts(float x) noexcept {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t n = (bits - 0x3F3504F3) >> 23;  // 3F3504F3h is sqrt(1/2)
  return {.mantissa = std::bit_cast<float>(bits - n * (1 << 23)), .exponent = n};
}

}  // namespace plenum::numeric
