// A fixed-point number that saturates: Q31.32, a 64 bit word in units of 2^-32.
//
//   range       -2^31 to 2^31 - 2^-32; a result beyond is cut off there, and counted (saturations())
//   resolution  2^-32 (2.3e-10): the ulp of the table
//   rounding    to the nearest; a tie goes up in a product, away from zero elsewhere
//
//   + - == < conversion of a whole number   exact
//   * / conversion of a float               1/2 ulp
//   near_ratio                              2^-25 of it, and 1 ulp
//   sqrt                                    1/2 ulp below 2^24, 16 ulp from there on
//   inverse_sqrt                            2^-28 of it, and 1 ulp
//
// Nothing traps: x/0 is the end of the range on x's side, 0/0 and not-a-number are 0, the root of a negative number is 0; each
// is counted.
//
// Every result is a function of the operands' bits, made with integers alone: the same on every machine, with every compiler
// and at every level of optimisation. Where there is a 128 bit integer a product uses it; elsewhere, products of 32 bits.
#pragma once

#include <array>
#include <bit>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

namespace plenum::numeric {

/// 2^31/d at the middles of 128 stretches of d from 2^31 to 2^32, in units of 2^-30: within 2^-8 of it.
inline constexpr auto kReciprocal = [] {
  std::array<std::uint32_t, 128> first{};
  for (std::size_t i = 0; i < first.size(); ++i) {
    first[i] = static_cast<std::uint32_t>((std::uint64_t{1} << 39U) / (257 + 2 * i));
  }
  return first;
}();

/// 1/sqrt(d) at the middles of the stretches of 2^-8 of d from 1/4 to 1, in units of 2^-30: within 2^-8 of it.
inline constexpr std::uint32_t kInverseRootFrom = 64;
inline constexpr auto kInverseRoot = [] {
  std::array<std::uint32_t, 256 - kInverseRootFrom> of{};
  for (std::size_t i = 0; i < of.size(); ++i) {
    const std::uint64_t d = 2 * (kInverseRootFrom + i) + 1;  // in units of 2^-9
    // the largest y with y y d <= 2^69
    std::uint64_t low = std::uint64_t{1} << 30U, high = std::uint64_t{1} << 31U;
    while (high - low > 1) {
      const std::uint64_t y = (low + high) / 2;
      (y * y <= (std::uint64_t{1} << 63U) / d * 64 ? low : high) = y;
    }
    of[i] = static_cast<std::uint32_t>(low);
  }
  return of;
}();

class Fixed {
  template <std::floating_point Real>
  using BitsOf = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;

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

  /// The nearest one. (2^-32 is taken off the exponent: a board without floating point would spend a call on the product.)
  template <std::floating_point Real>
  constexpr explicit operator Real() const noexcept {
    using Bits = BitsOf<Real>;
    constexpr Bits kOff = Bits{kFractionBits} << (std::numeric_limits<Real>::digits - 1);
    return raw_ == 0 ? Real{0} : std::bit_cast<Real>(std::bit_cast<Bits>(static_cast<Real>(raw_)) - kOff);
  }
  /// Without its fraction: towards zero.
  template <std::integral Whole>
  constexpr explicit operator Whole() const noexcept {
    const auto whole = static_cast<std::int64_t>(magnitude(raw_) >> kFractionBits);
    return static_cast<Whole>(raw_ < 0 ? -whole : whole);
  }

  constexpr auto operator<=>(const Fixed&) const noexcept =
      default;  // NOLINT(modernize-use-nullptr): of clang-tidy 14

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
    return from_raw(product_by_parts(a.raw_, b.raw_));
#endif
  }
  friend constexpr Fixed operator/(Fixed a, Fixed b) noexcept {
    return from_raw(ratio(a.raw_, b.raw_));
  }

  friend constexpr Fixed near_ratio(Fixed a, Fixed b) noexcept;
  template <int bits>
  friend constexpr Fixed ratio_within(Fixed a, Fixed b) noexcept;
  template <int bits>
  friend constexpr Fixed product_within(Fixed a, Fixed b) noexcept;
  friend constexpr Fixed sqrt(Fixed x) noexcept;
  friend constexpr Fixed inverse_sqrt(Fixed x) noexcept;
  friend constexpr Fixed within_2_29(Fixed x) noexcept;

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

  /// As operator*, of raw numbers, where the widest integer has 64 bits. (A 32 bit Arm passes and returns a class of 64 bits in
  /// memory, an integer in registers.)
  static constexpr std::int64_t product_by_parts(std::int64_t a, std::int64_t b) noexcept;

  /// How many results of this thread were cut off, or are no numbers; from 2^32 on it begins again.
  static std::uint32_t saturations() noexcept {
    return saturations_;
  }

 private:
  static constexpr std::int64_t kHalf = std::int64_t{1} << (kFractionBits - 1);

  static constexpr std::uint64_t magnitude(std::int64_t raw) noexcept {
    const auto bits = static_cast<std::uint64_t>(raw);
    return raw < 0 ? 0 - bits : bits;
  }
  static constexpr void count_saturation() noexcept {
    if (!std::is_constant_evaluated()) ++saturations_;
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
  static constexpr std::int64_t ratio(std::int64_t a, std::int64_t b) noexcept;
  static constexpr std::int64_t root(std::uint64_t raw) noexcept;
  /// A number d 2^(64 - 2 half_shift), d from 1/4 to 1 in units of 2^-32, and 1/sqrt(d) in units of 2^-30.
  struct InverseRoot {
    unsigned half_shift;
    std::uint32_t d;
    std::uint32_t y;
  };
  static constexpr InverseRoot inverse_root(std::uint64_t raw) noexcept;
  static constexpr std::uint64_t quotient(std::uint64_t a, std::uint64_t b) noexcept;
  static constexpr std::uint32_t reciprocal(std::uint32_t d) noexcept;
  /// Of b > 1: the reciprocal of its first 32 bits.
  struct Divisor {
    explicit constexpr Divisor(std::uint64_t b) noexcept
        : shift(static_cast<unsigned>(std::countl_zero(b))),
          r(reciprocal(static_cast<std::uint32_t>(b << shift >> 32U))) {}
    /// x r: all but its last 32 bits, and those.
    constexpr std::pair<std::uint64_t, std::uint32_t> times_r(std::uint64_t x) const noexcept {
      const std::uint64_t below = wide(static_cast<std::uint32_t>(x), r);
      const std::uint64_t above = wide(static_cast<std::uint32_t>(x >> 32U), r) + (below >> 32U);
      return {above, static_cast<std::uint32_t>(below)};
    }
    /// x 2^32/b by it, for x < 2^31 b.
    constexpr std::uint64_t estimate(std::uint64_t x) const noexcept {
      const auto [top, below] = times_r(x);
      return shift > 30 ? top << (shift - 30) | std::uint64_t{below} >> (62 - shift) : top >> (30 - shift);
    }

    unsigned shift;
    std::uint32_t r;
  };
  [[gnu::cold]] static constexpr std::int64_t any_product_by_parts(std::int64_t a, std::int64_t b) noexcept;
  static constexpr bool below_2_15(std::int32_t high) noexcept {
    return static_cast<std::uint32_t>(high) + 0x8000U < 0x10000U;
  }
  static constexpr std::uint64_t wide(std::uint32_t a, std::uint32_t b) noexcept {
    return std::uint64_t{a} * b;
  }

  std::int64_t raw_;  // as of any number, nothing is in it until something is put there
  static inline constinit thread_local std::uint32_t saturations_ = 0;
};

/// By the bits of the number: mantissa * 2^exponent. A board without floating point would spend a call on each operation.
template <class Real>
constexpr std::int64_t Fixed::nearest(Real real) noexcept {
  using Limits = std::numeric_limits<Real>;
  using Bits = BitsOf<Real>;
  static_assert(Limits::is_iec559 && sizeof(Real) == sizeof(Bits));
  constexpr int kMantissaBits = Limits::digits - 1;
  constexpr int kBias = Limits::max_exponent - 1;
  const auto bits = std::bit_cast<Bits>(real);
  const bool negative = bits >> (8 * sizeof(Bits) - 1) != 0;
  constexpr Bits kExponents = (Bits{1} << (8 * sizeof(Bits) - 1 - kMantissaBits)) - 1;
  const int exponent = static_cast<int>(bits >> kMantissaBits & kExponents);
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

constexpr std::int64_t Fixed::product_by_parts(std::int64_t a, std::int64_t b) noexcept {
  // a = a_high 2^32 + a_low with a signed a_low: the processor adds signed products of 32 bits to one of 64
  const auto a_low = static_cast<std::int32_t>(a), b_low = static_cast<std::int32_t>(b);
  const auto a_high = static_cast<std::int32_t>((static_cast<std::uint64_t>(a) + kHalf) >> 32U);
  const auto b_high = static_cast<std::int32_t>((static_cast<std::uint64_t>(b) + kHalf) >> 32U);
  if (below_2_15(a_high) && below_2_15(b_high)) {  // the product is in range
    std::int64_t sum = (std::int64_t{a_low} * b_low + kHalf) >> 32U;
    sum += std::int64_t{a_high} * b_low;
    sum += std::int64_t{a_low} * b_high;
    sum += static_cast<std::int64_t>(a_high * b_high) * (std::int64_t{1} << 32U);  // within 2^30
    return sum;
  }
  return any_product_by_parts(a, b);
}

constexpr std::int64_t Fixed::any_product_by_parts(std::int64_t a, std::int64_t b) noexcept {
  const auto low = [](std::uint64_t x) noexcept {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x));
  };
  const std::uint64_t x = magnitude(a), y = magnitude(b);
  const std::uint64_t across_x = (x >> 32U) * low(y), across_y = low(x) * (y >> 32U), below = low(x) * low(y);
  const std::uint64_t middle = (below >> 32U) + low(across_x) + low(across_y);
  std::uint64_t high = (x >> 32U) * (y >> 32U) + (across_x >> 32U) + (across_y >> 32U) + (middle >> 32U);
  const bool negative = (a < 0) != (b < 0);
  const std::uint64_t rounded = low(middle) * (std::uint64_t{1} << 32U) + low(below);
  const std::uint64_t up = negative ? kHalf - 1 : kHalf;  // a tie goes up
  high += rounded + up < rounded ? 1U : 0U;
  if (high >> 32U != 0) return saturated(negative);
  return with_sign(high << 32U | (rounded + up) >> 32U, negative);
}

/// 2^62/d or up to 16 less, for d from 2^31 on, by Newton's method: from below, whatever is rounded off.
constexpr std::uint32_t Fixed::reciprocal(std::uint32_t d) noexcept {
  std::uint32_t r = kReciprocal[d >> 24U & 0x7FU];
  for (int i = 0; i < 2; ++i) {  // each squares the error
    const auto left = static_cast<std::int32_t>(((std::uint64_t{1} << 62U) - wide(r, d)) >> 32U);
    r += static_cast<std::uint32_t>(std::int64_t{static_cast<std::int32_t>(r)} * left >> 30U);
  }
  return r - 8;
}

/// a 2^32/b rounded to the nearest, of magnitudes, for a < 2^31 b; b > 0.
constexpr std::uint64_t Fixed::quotient(std::uint64_t a, std::uint64_t b) noexcept {
  std::uint64_t whole = 0;
  std::uint64_t left = 0;  // a 2^32 - whole b
  if (a >> 57U == 0 && b > 1) {
    // Twice an estimate from below, by the reciprocal of b's first 32 bits: the second one is off by a few units at most.
    const Divisor by(b);
    whole = by.estimate(a);
    left = (a << 32U) - whole * b;
    const std::uint64_t more = by.times_r(left).first >> (62 - by.shift);
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

constexpr std::int64_t Fixed::ratio(std::int64_t a, std::int64_t b) noexcept {
  const std::uint64_t x = magnitude(a), y = magnitude(b);
  const bool negative = (a < 0) != (b < 0);
  if (x >> 31U >= y) {  // the quotient passes the range, or there is none
    if (x != 0) return saturated(negative);
    count_saturation();
    return 0;
  }
  return with_sign(quotient(x, y), negative);
}

/// a/b of b > 0 for half the price: its error is in the table above.
constexpr Fixed near_ratio(Fixed a, Fixed b) noexcept {
  const std::uint64_t x = Fixed::magnitude(a.raw_);
  if (b.raw_ <= 1 || x >> 31U >= static_cast<std::uint64_t>(b.raw_)) return a / b;
  const std::uint64_t whole = Fixed::Divisor(static_cast<std::uint64_t>(b.raw_)).estimate(x);
  return Fixed::from_raw(Fixed::with_sign(whole, a.raw_ < 0));
}

/// a/b, but no further than 2^bits from 0, and that of x/0; 0 of 0/0. Not counted: what asks for it loses nothing.
template <int bits>
constexpr Fixed ratio_within(Fixed a, Fixed b) noexcept {
  static_assert(bits >= 0 && bits < 31);
  const std::uint64_t x = Fixed::magnitude(a.raw_), y = Fixed::magnitude(b.raw_);
  const bool negative = (a.raw_ < 0) != (b.raw_ < 0);
  if (x >> static_cast<unsigned>(bits) < y)
    return Fixed::from_raw(Fixed::with_sign(Fixed::quotient(x, y), negative));
  if (x == 0) return 0;
  constexpr std::int64_t kMost = std::int64_t{1} << (bits + Fixed::kFractionBits);
  return Fixed::from_raw(negative ? -kMost : kMost);
}

/// a b, but no further than 2^bits from 0. Not counted, as above.
template <int bits>
constexpr Fixed product_within(Fixed a, Fixed b) noexcept {
  static_assert(bits >= 0 && bits < 31);
  constexpr std::int64_t kMost = std::int64_t{1} << (bits + Fixed::kFractionBits);
#ifdef __SIZEOF_INT128__
  __extension__ using Wide = __int128;
  const Wide product = (static_cast<Wide>(a.raw_) * b.raw_ + Fixed::kHalf) >> Fixed::kFractionBits;
  if (product > kMost) return Fixed::from_raw(kMost);
  if (product < -kMost) return Fixed::from_raw(-kMost);
  return Fixed::from_raw(static_cast<std::int64_t>(product));
#else
  const std::uint32_t counted = Fixed::saturations_;
  const std::int64_t product = Fixed::product_by_parts(a.raw_, b.raw_);
  if (product > kMost || product < -kMost) {
    Fixed::saturations_ = counted;
    return Fixed::from_raw(product < 0 ? -kMost : kMost);
  }
  return Fixed::from_raw(product);
#endif
}

/// Of raw > 0. By Newton's method from a table.
constexpr Fixed::InverseRoot Fixed::inverse_root(std::uint64_t raw) noexcept {
  const unsigned half_shift = static_cast<unsigned>(std::countl_zero(raw | 1U)) / 2;
  const auto d = static_cast<std::uint32_t>(raw << (2 * half_shift) >> 32U);
  constexpr std::uint32_t kOne = std::uint32_t{1} << 30U;
  std::uint32_t y = kInverseRoot[(d >> 24U) - kInverseRootFrom];
  for (int i = 0; i < 2; ++i) {
    const auto d_y = static_cast<std::uint32_t>(wide(d, y) >> 32U);
    const auto d_y_y = static_cast<std::uint32_t>(wide(d_y, y) >> 30U);
    y = static_cast<std::uint32_t>(wide(y, 3 * kOne - d_y_y) >> 31U);
  }
  return {.half_shift = half_shift, .d = d, .y = y};
}

/// The root of `raw` 2^32, for 0 < raw < 2^56.
constexpr std::int64_t Fixed::root(std::uint64_t raw) noexcept {
  const auto [half_shift, d, y] = inverse_root(raw);
  // d y to 32 bits, moved back; and one step of Newton's for the rest, and what that rounded off
  std::uint64_t root = wide(d, y) >> 30U;
  root = half_shift < 16 ? root << (16 - half_shift) : root >> (half_shift - 16);
  const std::uint64_t square = raw << 32U;  // of the root, modulo 2^64
  auto left = static_cast<std::int64_t>(square - root * root);
  const std::int64_t by_y =
      std::int64_t{static_cast<std::int32_t>(left >> 32U)} * static_cast<std::int32_t>(y) +
      static_cast<std::int64_t>(wide(static_cast<std::uint32_t>(left), y) >> 32U);
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
  return static_cast<std::int64_t>(left > static_cast<std::int64_t>(root) ? root + 1 : root);
}

/// Square root: its error is in the table above.
constexpr Fixed sqrt(Fixed x) noexcept {
  const std::int64_t raw = x.raw_;
  if (raw <= 0) {
    if (raw < 0) Fixed::count_saturation();
    return {};
  }
  const auto of = static_cast<std::uint64_t>(raw);
  return Fixed::from_raw(of >> 56U != 0 ? Fixed::root(of >> 8U) * 16 : Fixed::root(of));
}

/// 1/sqrt(x): its error is in the table above; 0 for x <= 0, which is counted.
constexpr Fixed inverse_sqrt(Fixed x) noexcept {
  if (x.raw_ <= 0) {
    Fixed::count_saturation();
    return 0;
  }
  const auto [half_shift, d, y] = Fixed::inverse_root(static_cast<std::uint64_t>(x.raw_));
  return Fixed::from_raw(static_cast<std::int64_t>(std::uint64_t{y} << half_shift >> 14U));
}

/// x, but no further than 2^29 from 0, and then counted: so that products with a part, and their sums, pass no range.
constexpr Fixed within_2_29(Fixed x) noexcept {
  constexpr std::int64_t kMost = std::int64_t{1} << (29 + Fixed::kFractionBits);
  if (x.raw_ <= kMost && x.raw_ >= -kMost) return x;
  Fixed::count_saturation();
  return Fixed::from_raw(x.raw_ < 0 ? -kMost : kMost);
}

/// A part of a whole, from 0 to 1 - 2^-32 in units of 2^-32: as a factor it costs half of what a Fixed does, and nothing is cut off.
class Fraction {
 public:
  constexpr Fraction() noexcept = default;
  constexpr explicit Fraction(std::uint32_t raw) noexcept : raw_(raw) {}

  constexpr operator Fixed() const noexcept { return Fixed::from_raw(raw_); }
  constexpr std::uint32_t raw() const noexcept { return raw_; }

  /// To the nearest, a tie up.
  friend constexpr Fixed operator*(Fixed of, Fraction part) noexcept {
    return product(of, part, 0x80000000U);
  }
  /// The same, rounded down.
  friend constexpr Fixed times_down(Fixed of, Fraction part) noexcept { return product(of, part, 0); }

 private:
  /// Rounded down after `added`, in units of 2^-64.
  static constexpr Fixed product(Fixed of, Fraction part, std::uint32_t added) noexcept {
    const std::int64_t raw = of.raw();
    const auto high = static_cast<std::int32_t>(raw >> 32U);
    const std::uint64_t below = std::uint64_t{static_cast<std::uint32_t>(raw)} * part.raw_ + added;
    return Fixed::from_raw(std::int64_t{high} * part.raw_ + static_cast<std::int64_t>(below >> 32U));
  }

  std::uint32_t raw_;
};

}  // namespace plenum::numeric
