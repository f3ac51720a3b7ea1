// When a frame was on its bus, as logs and servers write it: "1700000000.123456".
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace plenum::host::wire {

/// Seconds with six decimals, in microseconds; empty for other text, and for what 64 bits do not hold.
inline std::optional<std::uint64_t> parse_stamp_us(std::string_view text) noexcept {
  constexpr std::size_t kDecimals = 6;
  constexpr std::uint64_t kLargest_s = UINT64_MAX / 1'000'000 - 1;
  const auto number = [](std::string_view digits) -> std::optional<std::uint64_t> {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
    return value;
  };
  const std::size_t point = text.find('.');
  if (point == std::string_view::npos || text.size() - point - 1 != kDecimals) return std::nullopt;
  const auto seconds = number(text.substr(0, point)), us = number(text.substr(point + 1));
  if (!seconds || !us || *seconds > kLargest_s) return std::nullopt;
  return *seconds * 1'000'000 + *us;
}

}  // namespace plenum::host::wire
