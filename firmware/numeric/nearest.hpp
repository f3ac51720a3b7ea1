// Numbers by their bits, where a board without floating point would spend a call on each operation: the nearest whole number of a
// range, as it goes on a bus or into a log, and which of two is the greater.
#pragma once

#include <bit>
#include <cstdint>

#include "firmware/numeric/fixed.hpp"
#include "firmware/numeric/order.hpp"

namespace plenum::numeric {

/// The nearest whole number, a tie away from zero, cut off at limits that lie within 2^22; `if_nan` for not-a-number.
constexpr std::int32_t nearest_within(float value, std::int32_t low, std::int32_t high,
                                      std::int32_t if_nan) noexcept {
  constexpr std::uint32_t kInfinity = 0x7F80'0000U;
  constexpr auto kBeyond = std::bit_cast<std::uint32_t>(0x1p22F);
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t magnitude = bits & 0x7FFF'FFFFU;
  const bool negative = bits != magnitude;
  if (magnitude > kInfinity) return if_nan;
  if (magnitude >= kBeyond) return negative ? low : high;
  return clamp(static_cast<std::int32_t>(value + (negative ? -0.5F : 0.5F)), low, high);
}

/// The same of a number that is always one.
constexpr std::int32_t nearest_within(Fixed value, std::int32_t low, std::int32_t high,
                                      std::int32_t /*if_nan*/) noexcept {
  const auto whole = static_cast<std::int32_t>(value.raw() >> 32U);  // rounded down
  if (whole >= high) return high;
  if (whole < low) return low;
  const auto above = static_cast<std::uint32_t>(value.raw());  // in units of 2^-32
  constexpr std::uint32_t kTie = 0x8000'0000U;
  return whole + (above > kTie || (above == kTie && whole >= 0) ? 1 : 0);
}

/// The place of a number among all that are: place_of(a) < place_of(b) is a < b. A positive not-a-number stands above all others, a
/// negative one below.
constexpr std::int32_t place_of(float x) noexcept {
  const auto bits = std::bit_cast<std::int32_t>(x);
  return bits < 0 ? -(bits & 0x7FFF'FFFF) : bits;
}

}  // namespace plenum::numeric
