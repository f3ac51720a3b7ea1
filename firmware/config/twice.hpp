// A value that decides what may move, kept a second time as its complement: a bit that flips in either is seen.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

namespace plenum::config {

/// T: an integer or an enumeration of 32 bits at most, or a float, whose bits are what is kept twice.
template <class T>
class Twice {
 public:
  constexpr Twice(T value = T{}) noexcept : value_(value), complement_(inverted(bits_of(value))) {}

  constexpr operator T() const noexcept { return value_; }
  constexpr T value() const noexcept { return value_; }
  constexpr bool intact() const noexcept { return complement_ == inverted(bits_of(value_)); }
  /// What the complement says; the value while intact().
  constexpr T second() const noexcept { return value_of(inverted(complement_)); }

 private:
  using IsFloat = std::is_same<T, float>;
  using Bits = std::conditional_t<IsFloat::value, std::uint32_t, T>;
  static constexpr Bits inverted(Bits bits) noexcept {
    return static_cast<Bits>(~static_cast<std::uint32_t>(bits));
  }
  static constexpr Bits bits_of(T value) noexcept {
    if constexpr (IsFloat::value) {
      return std::bit_cast<Bits>(value);
    } else {
      return value;
    }
  }
  static constexpr T value_of(Bits bits) noexcept {
    if constexpr (IsFloat::value) {
      return std::bit_cast<T>(bits);
    } else {
      return bits;
    }
  }

  T value_;
  Bits complement_;
};

}  // namespace plenum::config
