// A float as the nearest whole number of a range: what goes on a bus or into a log as a code.
#pragma once

#include <bit>
#include <cstdint>

#include "firmware/numeric/order.hpp"

namespace plenum::numeric {

/// The nearest whole number, a tie away from zero, cut off at limits that lie within 2^22; `if_nan` for not-a-number.
///
/// By the bits of the number: a board without floating point would spend a call on each comparison.
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

}  // namespace plenum::numeric
