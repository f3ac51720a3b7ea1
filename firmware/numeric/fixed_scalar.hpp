// Q31.32 as a scalar of the core (scalar.hpp): what is made of its bits.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "firmware/numeric/fixed.hpp"
#include "firmware/numeric/order.hpp"

namespace plenum::numeric {

/// Every one is a number.
constexpr bool is_finite(Fixed /*x*/) noexcept {
  return true;
}

/// x 2^-kBits: what a product with it gives, for less.
template <int kBits>
constexpr Fixed shifted_down(Fixed x) noexcept {
  constexpr std::int64_t kHalf = std::int64_t{1} << (kBits - 1);
  return Fixed::from_raw((x.raw() >> kBits) + ((x.raw() & kHalf) != 0 ? 1 : 0));
}

/// x/1000 to an ulp, and 3e-10 of it.
constexpr Fixed thousandth(Fixed x) noexcept {
  constexpr int kBits = 9;
  constexpr auto kOf = Fraction(static_cast<std::uint32_t>((std::uint64_t{1} << (32 + kBits)) / 1000 + 1));
  return shifted_down<kBits>(x * kOf);
}

/// What decay() knows beforehand.
struct DecayTable {
  static constexpr int kBits = 10;
  std::array<std::uint32_t, 1U << kBits>
      power{};  ///< 2^-(i/1024) in units of 2^-32, rounded down: what is taken off is, too
  // of y and -y^2 in 1 - 2^-(y/1024), in units of 2^-42
  std::uint32_t linear = 0;
  std::uint32_t square = 0;
};
inline constexpr DecayTable kDecay = [] {
  // NOLINTNEXTLINE(bugprone-incorrect-roundings)
  const auto nearest = [](auto x) { return static_cast<std::uint32_t>(x + 0.5); };
  DecayTable table;
  const auto series = [](auto x) {  // of e^-x
    auto sum = 1.0;
    for (int k = 24; k > 0; --k) sum = 1.0 - x / k * sum;
    return sum;
  };
  constexpr auto kStep = std::numbers::ln2 / (1U << DecayTable::kBits);
  table.power[0] = 0xFFFFFFFFU;
  for (std::size_t i = 1; i < table.power.size(); ++i) {
    table.power[i] = static_cast<std::uint32_t>(0x1p32 * series(kStep * static_cast<int>(i)));
  }
  // Of the third term, y^3, what a quadratic can take of it from 0 to 1: 1.5 y^2 - 0.5625 y, within 1/32.
  constexpr auto kFirst = 0x1p42 * kStep, kSecond = kFirst * kStep / 2, kThird = kSecond * kStep / 3;
  table.linear = nearest(kFirst - 0.5625 * kThird);
  table.square = nearest(kSecond - 1.5 * kThird);
  return table;
}();

/// log2 e in units of 2^-31. NOLINTNEXTLINE(bugprone-incorrect-roundings)
inline constexpr auto kLog2eRaw = static_cast<std::uint32_t>(0x1p31 * std::numbers::log2e + 0.5);

/// 2^-t in units of 2^-32, one less for t = 0, for t in units of 2^-32 below 32.
///
/// Method: t = n + i/1024 + y/1024, 2^-(i/1024) by a table, and 1 - 2^-(y/1024) by a quadratic (remainder 2e-12) in 32 bit
/// products.
constexpr std::uint32_t power_of_half(std::uint64_t t) noexcept {
  const auto times = [](std::uint32_t a, std::uint32_t b) noexcept {
    return static_cast<std::uint32_t>(std::uint64_t{a} * b >> 32U);
  };
  const auto fraction = static_cast<std::uint32_t>(t);
  const std::uint32_t y = fraction << DecayTable::kBits;
  const std::uint32_t done = times(y, kDecay.linear - times(y, kDecay.square));
  const std::uint32_t power = kDecay.power[fraction >> (32 - DecayTable::kBits)];
  return (power - (times(power, done) >> DecayTable::kBits)) >> (t >> 32U);
}

/// t of e^-x = 2^-t, x log2 e, in units of 2^-32: of x > 0, and at least 32 beyond kDecayHigh.
constexpr std::uint64_t halvings(Fixed x) noexcept {
  const auto raw = static_cast<std::uint64_t>(min(x, Fixed(kDecayHigh)).raw());
  return (raw >> 32U) * kLog2eRaw * 2 + ((raw & 0xFFFFFFFFU) * kLog2eRaw >> 31U);
}

/// 1 - e^-x for x clamped to [0, kDecayHigh]; error below 2.5 ulp.
constexpr Fixed decay(Fixed x) noexcept {
  constexpr Fixed kOne = 1;
  if (x <= Fixed(0)) return Fixed(0);
  const std::uint64_t t = halvings(x);
  if (t >> 37U != 0) return kOne;
  return Fixed::from_raw(kOne.raw() - static_cast<std::int64_t>(power_of_half(t)));
}

/// 1 - 2^-t, up to 1 - 2^-32, for t in units of 2^-32; of a negative t 0.
constexpr Fraction done_after(std::int64_t t) noexcept {
  const bool within = static_cast<std::uint32_t>(t >> 32U) < 32;
  if (within) return Fraction(~power_of_half(static_cast<std::uint64_t>(t)));
  return Fraction(t < 0 ? 0 : 0xFFFFFFFFU);
}

/// decay(x) as a part, and what a part leaves of the whole: both up to 1 - 2^-32.
constexpr Fraction decay_part(Fixed x) noexcept {
  return x <= Fixed(0) ? Fraction(0) : done_after(static_cast<std::int64_t>(halvings(x)));
}
constexpr Fraction rest_of(Fraction part) noexcept {
  return Fraction(~part.raw());
}

/// A power of two above x; below 2^31.
constexpr Fixed whole_above(Fixed x) noexcept {
  Fixed whole = 1;
  while (whole <= x && whole < Fixed(1 << 30)) whole += whole;
  return whole;
}

/// x/whole to the nearest, x from 0 to below `whole`.
constexpr Fraction part_of(Fixed x, Fixed whole) noexcept {
  const Fixed most = Fixed::from_raw(0xFFFFFFFF);
  return Fraction(static_cast<std::uint32_t>(clamp(x / whole, Fixed(0), most).raw()));
}

/// done = decay(gain k + shift) for many k, gain log2 e and shift log2 e held within 2^29: error below 3 ulp and what an ulp of gain and
/// shift makes of it.
template <std::size_t kCount>
constexpr void decays(Fixed gain, Fixed shift, const std::array<Fraction, kCount>& k,
                      std::array<Fraction, kCount>& done) noexcept {
  constexpr Fixed kPerOne = Fixed::from_raw(std::int64_t{kLog2eRaw} * 2);
  const Fixed t_gain = within_2_29(gain * kPerOne);  // of powers of a half
  const std::int64_t t_shift = within_2_29(shift * kPerOne).raw();
  for (std::size_t i = 0; i < kCount; ++i) done[i] = done_after(times_down(t_gain, k[i]).raw() + t_shift);
}

/// share = (of + shift) part - less for many, |of| below 2^30, shift and less held within 2^29: the nearest, a tie up.
template <std::size_t kCount>
constexpr void shares(const std::array<Fixed, kCount>& of, Fixed shift,
                      const std::array<Fraction, kCount>& part, Fixed less,
                      std::array<Fixed, kCount>& share) noexcept {
  const std::int64_t add = within_2_29(shift).raw(), subtract = within_2_29(less).raw();
  for (std::size_t i = 0; i < kCount; ++i) {
    share[i] = Fixed::from_raw((Fixed::from_raw(of[i].raw() + add) * part[i]).raw() - subtract);
  }
}

/// Of x > 0; the mantissa to an ulp.
constexpr Parts<Fixed> parts(Fixed x) noexcept {
  constexpr auto kSqrt2 = static_cast<std::uint64_t>(0x1p63 * std::numbers::sqrt2);
  const auto raw = static_cast<std::uint64_t>(x.raw());
  const int zeros = std::countl_zero(raw);
  const std::uint64_t mantissa = raw << zeros;  // 1 to 2, in units of 2^-63
  const int to_half = mantissa > kSqrt2 ? 1 : 0;
  return {.mantissa = Fixed::from_raw(static_cast<std::int64_t>(mantissa >> (31 + to_half))),
          .exponent = 31 - zeros + to_half};
}

}  // namespace plenum::numeric
