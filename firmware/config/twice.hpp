// A value that decides what may move, kept a second time as its complement: a bit that flips in either is seen.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

namespace plenum::config {

/// T: any number or enumeration of 64 bits at most, all of which are of its value.
template <class T>
class Twice {
 public:
  constexpr Twice(T value = T{}) noexcept
      : value_(value), complement_(inverted(std::bit_cast<Bits>(value))) {}

  constexpr operator T() const noexcept { return value_; }
  constexpr T value() const noexcept { return value_; }
  constexpr bool intact() const noexcept { return complement_ == inverted(std::bit_cast<Bits>(value_)); }
  /// What the complement says; the value while intact().
  constexpr T second() const noexcept { return std::bit_cast<T>(inverted(complement_)); }

  /// Of what the language itself compares nothing need be said.
  friend constexpr bool operator==(const Twice& a, const Twice& b) noexcept requires std::is_class_v<T> {
    return a.value_ == b.value_;
  }

 private:
  using UpTo16 = std::conditional_t<sizeof(T) == 1, std::uint8_t, std::uint16_t>;
  using UpTo64 = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  using Bits = std::conditional_t<(sizeof(T) < 4), UpTo16, UpTo64>;
  static_assert(sizeof(T) == sizeof(Bits));

  static constexpr Bits inverted(Bits bits) noexcept { return static_cast<Bits>(~bits); }

  T value_;
  Bits complement_;
};

}  // namespace plenum::config
