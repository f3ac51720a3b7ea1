// A fixed-point number that saturates: Q31.32, a 64 bit word in units of 2^-32.
//
//   range       -2^31 to 2^31 - 2^-32; a result beyond is cut off there, and counted (saturations())
//   resolution  2^-32 (2.3e-10): the ulp of the table
//   rounding    to the nearest; a tie goes up in a product, away from zero elsewhere
//
//   + - == < conversion of a whole number   exact
//   * / conversion of a float               1/2 ulp
//   sqrt                                    1/2 ulp below 2^24, 16 ulp from there on
//
// Nothing traps: x/0 is the end of the range on x's side, 0/0 and not-a-number are 0, the root of a negative number is 0; each
// is counted.
//
// Every result is a function of the operands' bits, made with integers alone: the same on every machine, with every compiler
// and at every level of optimisation. Where there is a 128 bit integer a product uses it; elsewhere, products of 32 bits.
#pragma once

#include <bit>
#include <compare>
#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

namespace plenum::numeric {

class Fixed {
 public:
  static constexpr int kFractionBits = 32;

  constexpr Fixed() noexcept = default;

  // From what C++ calls a number without a word; back, only when asked: what is computed with a Fixed stays one.
  template <std::integral Whole>
  constexpr Fixed(Whole whole) noexcept
      : raw_(std::in_range<std::int32_t>(whole)
                 ? static_cast<std::int64_t>(whole) * (std::int64_t{1} << kFractionBits)
                 : saturated(whole < 0)) {}

  template <std::floating_point Real>
  constexpr Fixed(Real real) noexcept : raw_(nearest(real)) {}

  static constexpr Fixed from_raw(std::int64_t raw) noexcept {
    Fixed x;
    x.raw_ = raw;
    return x;
  }
  /// In units of 2^-32.
  constexpr std::int64_t raw() const noexcept { return raw_; }

  /// The nearest one.
  template <std::floating_point Real>
  constexpr explicit operator Real() const noexcept {
    return static_cast<Real>(raw_) * static_cast<Real>(0x1p-32F);
  }
  /// Without its fraction: towards zero.
  template <std::integral Whole>
  constexpr explicit operator Whole() const noexcept {
    const auto whole = static_cast<std::int64_t>(magnitude(raw_) >> kFractionBits);
    return static_cast<Whole>(raw_ < 0 ? -whole : whole);
  }

  constexpr auto operator<=>(const Fixed&) const noexcept = default;

  constexpr Fixed operator-() const noexcept { return Fixed() - *this; }

  friend constexpr Fixed operator+(Fixed a, Fixed b) noexcept {
    std::int64_t sum = 0;
    if (__builtin_add_overflow(a.raw_, b.raw_, &sum)) sum = saturated(a.raw_ < 0);
    return from_raw(sum);
  }
  friend constexpr Fixed operator-(Fixed a, Fixed b) noexcept {
    std::int64_t difference = 0;
    if (__builtin_sub_overflow(a.raw_, b.raw_, &difference)) difference = saturated(a.raw_ < 0);
    return from_raw(difference);
  }
  friend constexpr Fixed operator*(Fixed a, Fixed b) noexcept {
#ifdef __SIZEOF_INT128__
    __extension__ using Wide = __int128;
    const Wide product = (static_cast<Wide>(a.raw_) * b.raw_ + kHalf) >> kFractionBits;
    const auto kept = static_cast<std::int64_t>(product);
    return from_raw(kept == product ? kept : saturated((a.raw_ < 0) != (b.raw_ < 0)));
#else
    return product_by_parts(a, b);
#endif
  }
  friend constexpr Fixed operator/(Fixed a, Fixed b) noexcept;

  constexpr Fixed& operator+=(Fixed x) noexcept {
    return *this = *this + x;
  }
  constexpr Fixed& operator-=(Fixed x) noexcept {
    return *this = *this - x;
  }
  constexpr Fixed& operator*=(Fixed x) noexcept {
    return *this = *this * x;
  }
  constexpr Fixed& operator/=(Fixed x) noexcept {
    return *this = *this / x;
  }

  /// a * b where the widest integer has 64 bits.
  static constexpr Fixed product_by_parts(Fixed a, Fixed b) noexcept;

  /// How many results of this thread were cut off, or are no numbers; from 2^32 on it begins again.
  static std::uint32_t saturations() noexcept {
    return saturations_;
  }

  static constexpr void count_saturation() noexcept {
    if (!std::is_constant_evaluated()) ++saturations_;
  }

 private:
  static constexpr std::int64_t kHalf = std::int64_t{1} << (kFractionBits - 1);

  static constexpr std::uint64_t magnitude(std::int64_t raw) noexcept {
    const auto bits = static_cast<std::uint64_t>(raw);
    return raw < 0 ? 0 - bits : bits;
  }
  /// Of a magnitude up to 2^63.
  static constexpr std::int64_t with_sign(std::uint64_t magnitude, bool negative) noexcept {
    if (magnitude >> 63U == 0 || (negative && magnitude << 1U == 0)) {
      return static_cast<std::int64_t>(negative ? 0 - magnitude : magnitude);
    }
    return saturated(negative);
  }
  static constexpr std::int64_t saturated(bool negative) noexcept {
    count_saturation();
    return negative ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
  }
  template <class Real>
  static constexpr std::int64_t nearest(Real real) noexcept;
  static constexpr std::uint64_t quotient(std::uint64_t a, std::uint64_t b) noexcept;
  static constexpr std::uint64_t reciprocal(std::uint32_t d) noexcept;

  std::int64_t raw_ = 0;
  static inline constinit thread_local std::uint32_t saturations_ = 0;
};

/// By the bits of the number: mantissa * 2^exponent. A board without floating point would spend a call on each operation.
template <class Real>
constexpr std::int64_t Fixed::nearest(Real real) noexcept {
  using Limits = std::numeric_limits<Real>;
  using Bits = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
  static_assert(Limits::is_iec559 && sizeof(Real) == sizeof(Bits));
  constexpr int kMantissaBits = Limits::digits - 1;
  constexpr int kBias = Limits::max_exponent - 1;
  const auto bits = std::bit_cast<Bits>(real);
  const bool negative = bits >> (8 * sizeof(Bits) - 1) != 0;
  const int exponent = static_cast<int>(bits >> kMantissaBits & (2 * kBias + 1));
  std::uint64_t mantissa = bits & ((Bits{1} << kMantissaBits) - 1);
  if (exponent == 2 * kBias + 1 && mantissa != 0) {
    count_saturation();
    return 0;
  }
  if (exponent == 0) return 0;  // subnormal: far below half an ulp
  mantissa |= std::uint64_t{1} << kMantissaBits;
  const int shift = exponent - kBias - kMantissaBits + kFractionBits;
  if (shift > 63 - kMantissaBits) return saturated(negative);
  if (shift >= 0) return with_sign(mantissa << shift, negative);
  if (-shift > kMantissaBits + 1) return 0;
  return with_sign((mantissa + (std::uint64_t{1} << (-shift - 1))) >> -shift, negative);
}

constexpr Fixed Fixed::product_by_parts(Fixed a, Fixed b) noexcept {
  const auto low = [](auto x) noexcept { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)); };
  const auto a_high = static_cast<std::int32_t>(a.raw_ >> 32U);
  const auto b_high = static_cast<std::int32_t>(b.raw_ >> 32U);
  const auto fits = [](std::int32_t high) noexcept { return high >= -0x8000 && high < 0x8000; };
  if (fits(a_high) && fits(b_high)) {  // then no part and no sum can pass the range
    const std::int64_t across =
        static_cast<std::int64_t>(low(b.raw_)) * a_high + static_cast<std::int64_t>(low(a.raw_)) * b_high;
    const std::uint64_t below = low(a.raw_) * low(b.raw_) + kHalf;
    return from_raw(std::int64_t{a_high * b_high} * (std::int64_t{1} << 32U) + across +
                    static_cast<std::int64_t>(below >> 32U));
  }
  const std::uint64_t x = magnitude(a.raw_), y = magnitude(b.raw_);
  const std::uint64_t across_x = (x >> 32U) * low(y), across_y = low(x) * (y >> 32U), below = low(x) * low(y);
  const std::uint64_t middle = (below >> 32U) + low(across_x) + low(across_y);
  std::uint64_t high = (x >> 32U) * (y >> 32U) + (across_x >> 32U) + (across_y >> 32U) + (middle >> 32U);
  const bool negative = (a.raw_ < 0) != (b.raw_ < 0);
  const std::uint64_t rounded = low(middle) * (std::uint64_t{1} << 32U) + low(below);
  const std::uint64_t up = negative ? kHalf - 1 : kHalf;  // a tie goes up
  high += rounded + up < rounded ? 1U : 0U;
  if (high >> 32U != 0) return from_raw(saturated(negative));
  return from_raw(with_sign(high << 32U | (rounded + up) >> 32U, negative));
}

/// 2^63/d or up to 16 less, for d of 2^31 or more, by Newton's method: from below, whatever is rounded off.
constexpr std::uint64_t Fixed::reciprocal(std::uint32_t d) noexcept {
  // 48/17 - 32/17 x is within 1/17 of 1/x for x of 1/2 to 1; each step squares that
  constexpr std::uint64_t kAtZero = 48 * (std::uint64_t{1} << 31U) / 17,
                          kSlope = 32 * (std::uint64_t{1} << 31U) / 17;
  std::uint64_t r = kAtZero - (kSlope * d >> 32U);
  for (int i = 0; i < 3; ++i) {
    const std::uint64_t left = (std::uint64_t{1} << 63U) - r * d;  // may be a little negative, modulo 2^64
    r += static_cast<std::uint64_t>(static_cast<std::int64_t>(r) * (static_cast<std::int64_t>(left) >> 32U) >>
                                    31U);
  }
  return r - 8;
}

/// a 2^32/b rounded to the nearest, of magnitudes, for a < 2^31 b; b > 0.
constexpr std::uint64_t Fixed::quotient(std::uint64_t a, std::uint64_t b) noexcept {
  std::uint64_t whole = 0;
  std::uint64_t left = 0;  // a 2^32 - whole b
  if (a >> 57U == 0) {
    // Twice an estimate from below, by the reciprocal of b's first 32 bits: the second one is off by a few units at most.
    const auto shift = static_cast<unsigned>(std::countl_zero(b));
    const std::uint64_t r = reciprocal(static_cast<std::uint32_t>(b << shift >> 32U));
    const std::uint64_t above = (a >> 32U) * r, below = (a & 0xFFFFFFFFU) * r;
    const std::uint64_t top = above + (below >> 32U);  // a r 2^-32
    whole = shift > 31 ? top << (shift - 31) | (below & 0xFFFFFFFFU) >> (63 - shift) : top >> (31 - shift);
    left = (a << 32U) - whole * b;
    const std::uint64_t more = ((left >> 32U) * r + ((left & 0xFFFFFFFFU) * r >> 32U)) >> (63 - shift);
    whole += more;
    left -= more * b;
    while (left >= b) {
      ++whole;
      left -= b;
    }
  } else {
    whole = a / b;
    left = a % b;
    for (int i = 0; i < kFractionBits; ++i) {
      left <<= 1U;
      whole <<= 1U;
      if (left < b) continue;
      left -= b;
      ++whole;
    }
  }
  return left >= b - left ? whole + 1 : whole;
}

constexpr Fixed operator/(Fixed a, Fixed b) noexcept {
  const std::uint64_t x = Fixed::magnitude(a.raw_), y = Fixed::magnitude(b.raw_);
  const bool negative = (a.raw_ < 0) != (b.raw_ < 0);
  if (x >> 31U >= y) {  // the quotient passes the range, or there is none
    if (x != 0) return Fixed::from_raw(Fixed::saturated(negative));
    Fixed::count_saturation();
    return {};
  }
  return Fixed::from_raw(Fixed::with_sign(Fixed::quotient(x, y), negative));
}

/// Square root: its error is in the table above.
constexpr Fixed sqrt(Fixed x) noexcept {
  if (x.raw() <= 0) {
    if (x.raw() < 0) Fixed::count_saturation();
    return {};
  }
  const auto of = static_cast<std::uint64_t>(x.raw());
  if (of >> 56U != 0) return Fixed::from_raw(sqrt(Fixed::from_raw(x.raw() >> 8U)).raw() * 16);
  // d, the number moved to 1/4 .. 1 by an even shift, in 32 bits; y = 1/sqrt(d) by Newton's method from a straight line that
  // is within a tenth of it
  const unsigned half_shift = static_cast<unsigned>(std::countl_zero(of)) / 2;
  const std::uint64_t d = of << (2 * half_shift) >> 32U;
  constexpr std::uint64_t kOne = std::uint64_t{1} << 30U;
  std::uint64_t y = kOne * 22 / 10 - (d * 13 / 10 >> 2U);
  for (int i = 0; i < 4; ++i) {
    const std::uint64_t square = (y * y >> 30U) * d >> 32U;  // d y^2
    y = y * (3 * kOne - square) >> 31U;
  }
  // d y to 32 bits, moved back; and one step of Newton's for the rest, and what that rounded off
  std::uint64_t root = d * y >> 30U;
  root = half_shift < 16 ? root << (16 - half_shift) : root >> (half_shift - 16);
  const std::uint64_t square = of << 32U;  // of the root, modulo 2^64
  auto left = static_cast<std::int64_t>(square - root * root);
  const std::int64_t by_y =
      (left >> 32U) * static_cast<std::int64_t>(y) +
      static_cast<std::int64_t>((static_cast<std::uint64_t>(left) & 0xFFFFFFFFU) * y >> 32U);
  root += static_cast<std::uint64_t>(by_y >> (47 - half_shift));
  left = static_cast<std::int64_t>(square - root * root);
  while (left < 0) {
    --root;
    left += static_cast<std::int64_t>(2 * root + 1);
  }
  while (left > static_cast<std::int64_t>(2 * root)) {
    left -= static_cast<std::int64_t>(2 * root + 1);
    ++root;
  }
  return Fixed::from_raw(static_cast<std::int64_t>(left > static_cast<std::int64_t>(root) ? root + 1 : root));
}

}  // namespace plenum::numeric
