// One line of text, written without heap, locale or stdio.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace plenum::canopen {

/// What does not fit is cut off.
class TextLine {
 public:
  static constexpr std::size_t kCapacity = 240;

  void clear() noexcept { size_ = 0; }
  std::string_view text() const noexcept { return {text_.data(), size_}; }

  void put(std::string_view text) noexcept;
  /// `value` in at least `digits` hexadecimal digits, upper case, without a prefix.
  void hexadecimal(std::uint32_t value, int digits) noexcept;
  void decimal(std::int64_t value) noexcept;
  /// The shortest decimal number that lies nearer to `value` than to any other float (IEEE 754 binary32): 0.1, -12.5,
  /// 1e-07. At most nine digits. `value` must be finite.
  void real(float value) noexcept;

 private:
  void digits(std::uint64_t value, unsigned base, int least) noexcept;

  std::array<char, kCapacity> text_{};
  std::size_t size_ = 0;
};

}  // namespace plenum::canopen
