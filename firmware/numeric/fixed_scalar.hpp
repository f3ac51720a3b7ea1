// Q31.32 as a scalar of the core (scalar.hpp): what is made of its bits.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "firmware/numeric/fixed.hpp"
#include "firmware/numeric/order.hpp"

namespace plenum::numeric {

/// Every one is a number.
constexpr bool is_finite(Fixed /*x*/) noexcept {
  return true;
}

/// Of the series of 2^-(z + 1/2): (-ln2)^k/k! 2^-1/2, in units of 2^-31.
inline constexpr auto kDecayTerms = [] {
  std::array<std::int32_t, 9> terms{};
  auto term = 0x1p31 / std::numbers::sqrt2;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    terms[k] = static_cast<std::int32_t>(term < 0 ? term - 0.5
                                                  : term + 0.5);  // NOLINT(bugprone-incorrect-roundings)
    term *= -std::numbers::ln2 / static_cast<int>(k + 1);
  }
  return terms;
}();

/// 1 - e^-x for x clamped to [0, kDecayHigh]; error below 2.5 ulp.
///
/// Method: e^-x = 2^-t with t = x log2 e, t = n + 1/2 + z with |z| <= 1/2, and 2^-z by its Taylor polynomial of degree 8
/// (remainder below ulp) in 32 bit products.
constexpr Fixed decay(Fixed x) noexcept {
  constexpr auto kFirst = static_cast<std::uint64_t>(0x1p63 / std::numbers::sqrt2);
  // below 2^32
  constexpr auto kHalfLog2e =
      static_cast<std::uint64_t>(0x1p31 * std::numbers::log2e + 0.5);  // NOLINT(bugprone-incorrect-roundings)

  constexpr Fixed kOne = 1;
  if (x <= Fixed(0)) return Fixed(0);
  if (x >= Fixed(kDecayHigh)) return kOne;
  const auto raw = static_cast<std::uint64_t>(x.raw());
  const std::uint64_t t = (raw >> 32U) * kHalfLog2e * 2 + ((raw & 0xFFFFFFFFU) * kHalfLog2e >> 31U);
  const auto n = static_cast<unsigned>(t >> 32U);
  if (n > 32) return kOne;
  const auto z = static_cast<std::int32_t>(static_cast<std::uint32_t>(t) - 0x80000000U);
  std::int32_t sum = kDecayTerms.back();
  for (std::size_t k = kDecayTerms.size() - 2; k > 0; --k) {
    constexpr std::int64_t kHalf = std::int64_t{1} << 31U;
    sum = kDecayTerms[k] + static_cast<std::int32_t>((std::int64_t{sum} * z + kHalf) >> 32U);
  }
  const std::uint64_t power =
      kFirst + static_cast<std::uint64_t>(std::int64_t{sum} * z);  // 2^-(z + 1/2) in units of 2^-63
  const unsigned shift = n + 31;
  const std::uint64_t left = (power + (std::uint64_t{1} << (shift - 1))) >> shift;
  return Fixed::from_raw(kOne.raw() - static_cast<std::int64_t>(left));
}

/// Of x > 0; the mantissa to an ulp.
constexpr Parts<Fixed> parts(Fixed x) noexcept {
  constexpr auto kSqrt2 = static_cast<std::uint64_t>(0x1p63 * std::numbers::sqrt2);
  const auto raw = static_cast<std::uint64_t>(x.raw());
  const int zeros = std::countl_zero(raw);
  const std::uint64_t mantissa = raw << zeros;  // 1 to 2, in units of 2^-63
  const int to_half = mantissa > kSqrt2 ? 1 : 0;
  return {.mantissa = Fixed::from_raw(static_cast<std::int64_t>(mantissa >> (31 + to_half))),
          .exponent = 31 - zeros + to_half};
}

}  // namespace plenum::numeric
