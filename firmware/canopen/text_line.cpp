#include "firmware/canopen/text_line.hpp"

#include <algorithm>
#include <bit>

namespace plenum::canopen {
namespace {

/// digits x 10^exponent
struct Decimal {
  std::uint64_t digits;
  int exponent;
};

constexpr std::uint64_t kTop = std::uint64_t{1} << 60;

/// Scales mantissa x 2^binary to an integer of 17 or 18 digits x 10^exponent. Each step keeps 60 bits, 47 steps are the most:
/// the error stays below 2^-53 of the value, far less than half a unit of the float's 24 bits.
Decimal scaled(std::uint32_t mantissa, int binary) noexcept {
  std::uint64_t value = std::uint64_t{mantissa} << 36;
  int power = binary - 36;
  int exponent = 0;
  while (power < -3) {
    value *= 10;
    --exponent;
    for (; value >= kTop; value >>= 1) ++power;
  }
  while (power > 0) {
    value = (value << 4) / 10;
    ++exponent;
    power -= 4;
    for (; value >= kTop; value >>= 1) ++power;
  }
  return {value >> -power, exponent};
}

/// Of all decimals that lie nearer to the float than half the distance to its neighbour, the one with the fewest digits.
Decimal shortest(std::uint32_t mantissa, int binary) noexcept {
  constexpr std::uint32_t kHidden = 1U << 23;
  const std::uint32_t units = mantissa;
  for (; mantissa < kHidden; mantissa <<= 1) --binary;
  const Decimal exact = scaled(mantissa, binary);
  // below a power of two the neighbour is half as far
  const std::uint64_t room = exact.digits / units / (units == kHidden ? 4 : 2);
  std::uint64_t unit = 1'000'000'000'000'000'000U;
  for (int exponent = exact.exponent + 18; unit > 1; unit /= 10, --exponent) {
    const std::uint64_t rounded = (exact.digits + unit / 2) / unit;
    const std::uint64_t back = rounded * unit;
    const std::uint64_t off = back > exact.digits ? back - exact.digits : exact.digits - back;
    if (off < room) return {rounded, exponent};
  }
  return exact;
}

int count_digits(std::uint64_t value) noexcept {
  int count = 1;
  for (; value >= 10; value /= 10) ++count;
  return count;
}

}  // namespace

void TextLine::put(std::string_view text) noexcept {
  const std::size_t count = std::min(text.size(), kCapacity - size_);
  std::copy_n(text.begin(), count, text_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += count;
}

void TextLine::digits(std::uint64_t value, unsigned base, int least) noexcept {
  std::array<char, 20> reversed{};
  std::size_t count = 0;
  for (; value != 0 || least > 0; value /= base, --least) {
    reversed[count++] = "0123456789ABCDEF"[value % base];
  }
  for (; count > 0; --count) put({&reversed[count - 1], 1});
}

void TextLine::hexadecimal(std::uint32_t value, int digits_at_least) noexcept {
  digits(value, 16, digits_at_least);
}

void TextLine::decimal(std::int64_t value) noexcept {
  if (value < 0) put("-");
  const auto magnitude = static_cast<std::uint64_t>(value);
  digits(value < 0 ? 0U - magnitude : magnitude, 10, 1);
}

void TextLine::real(float value) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t fraction = bits & 0x7F'FFFFU;
  const auto biased = static_cast<int>(bits >> 23 & 0xFFU);
  if (bits >> 31 != 0) put("-");
  if (biased == 0 && fraction == 0) return put("0");

  const Decimal number =
      biased == 0 ? shortest(fraction, -149) : shortest(fraction | 0x80'0000U, biased - 150);
  const int count = count_digits(number.digits);
  const int point = count + number.exponent;  // value = 0.digits x 10^point
  std::uint64_t below = 1;                    // the digits' own place values behind the point
  if (number.exponent >= 0 && point <= 9) {
    digits(number.digits, 10, 1);
    for (int zero = 0; zero < number.exponent; ++zero) put("0");
  } else if (point > -4 && point <= 9) {
    for (int place = 0; place < std::min(-number.exponent, count); ++place) below *= 10;
    digits(number.digits / below, 10, 1);
    put(".");
    digits(number.digits % below, 10, -number.exponent);
  } else {
    for (int place = 1; place < count; ++place) below *= 10;
    digits(number.digits / below, 10, 1);
    if (count > 1) {
      put(".");
      digits(number.digits % below, 10, count - 1);
    }
    put(point > 0 ? "e+" : "e-");
    digits(static_cast<std::uint64_t>(point > 0 ? point - 1 : 1 - point), 10, 2);
  }
}

}  // namespace plenum::canopen
