// A value that decides what may move, kept a second time as its complement: a bit that flips in either is seen.
#pragma once

#include <cstdint>

namespace plenum::config {

/// T: an integer or an enumeration, of 32 bits at most.
template <class T>
class Twice {
 public:
  constexpr Twice(T value = T{}) noexcept : value_(value), complement_(inverted(value)) {}

  constexpr operator T() const noexcept { return value_; }
  constexpr T value() const noexcept { return value_; }
  constexpr bool intact() const noexcept { return complement_ == inverted(value_); }
  /// What the complement says; the value while intact().
  constexpr T second() const noexcept { return inverted(complement_); }

 private:
  static constexpr T inverted(T value) noexcept { return static_cast<T>(~static_cast<std::uint32_t>(value)); }

  T value_;
  T complement_;
};

}  // namespace plenum::config
