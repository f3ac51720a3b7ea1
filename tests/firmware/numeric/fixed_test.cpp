// Q31.32 against integers of 128 bits and the C library in long double: every error that fixed.hpp and fixed_scalar.hpp state.
#include "firmware/numeric/fixed.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>

#include "firmware/numeric/scalar.hpp"

namespace plenum::numeric {
namespace {

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
constexpr long double kUlps = 4294967296.0L;  // in 1

/// How many saturations what is done counts.
template <class Do>
std::uint32_t counted(Do&& what) {
  const std::uint32_t before = Fixed::saturations();
  what();
  return Fixed::saturations() - before;
}
template <class Do>
bool counts(Do&& what) {
  return counted(what) != 0;
}

#ifdef __SIZEOF_INT128__
__extension__ using Wide = __int128;

/// Of every magnitude alike, and of either sign.
std::int64_t any_raw(std::mt19937_64& random) {
  const auto magnitude = static_cast<std::int64_t>(random() >> 1U >> random() % 63);
  return random() % 2 == 0 ? magnitude : -magnitude;
}

std::int64_t cut(Wide x) {
  return x > kMost ? kMost : x < kLeast ? kLeast : static_cast<std::int64_t>(x);
}

TEST(Fixed, ProductsAreTheExactOnesRoundedWithWideIntegersAndWithout) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 2'000'000; ++i) {
    const std::int64_t a = any_raw(random), b = any_raw(random);
    const std::int64_t exact = cut((Wide{a} * b + (Wide{1} << 31)) >> 32);
    ASSERT_EQ((Fixed::from_raw(a) * Fixed::from_raw(b)).raw(), exact) << a << " * " << b;
    ASSERT_EQ(Fixed::product_by_parts(a, b), exact) << a << " * " << b;
  }
}

TEST(Fixed, QuotientsAreTheExactOnesRounded) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 2'000'000; ++i) {
    const std::int64_t a = any_raw(random), b = any_raw(random);
    if (b == 0) continue;
    const Wide dividend = (a < 0 ? -Wide{a} : Wide{a}) << 32, divisor = b < 0 ? -Wide{b} : Wide{b};
    const Wide magnitude = (2 * dividend + divisor) / (2 * divisor);
    ASSERT_EQ((Fixed::from_raw(a) / Fixed::from_raw(b)).raw(),
              cut((a < 0) != (b < 0) ? -magnitude : magnitude))
        << a << " / " << b;
  }
}

TEST(Fixed, NearRatiosAreWithinTwoToTheMinus25OfTheExactOnesAndAnUlp) {
  std::mt19937_64 random(6);
  for (int i = 0; i < 2'000'000; ++i) {
    const std::int64_t a = any_raw(random), b = std::abs(any_raw(random));
    if (b == 0) continue;
    const Wide dividend = (a < 0 ? -Wide{a} : Wide{a}) << 32;
    const std::int64_t got = near_ratio(Fixed::from_raw(a), Fixed::from_raw(b)).raw();
    if (dividend / b > kMost) {
      ASSERT_EQ(got, a < 0 ? kLeast : kMost) << a << " / " << b;
      continue;
    }
    // |got| b and the dividend, apart by an ulp of the quotient and a share of it
    const Wide off = (got < 0 ? -Wide{got} : Wide{got}) * b - dividend;
    ASSERT_LE(off < 0 ? -off : off, Wide{b} + (dividend >> 25)) << a << " / " << b;
    ASSERT_TRUE(got == 0 || (got < 0) == (a < 0));
  }
  EXPECT_EQ(near_ratio(Fixed(3), Fixed(0)).raw(), (Fixed(3) / Fixed(0)).raw());
}

/// `limited(a, b)` is `whole(a, b)` as far as 2^bits from 0, and not counted.
template <class Limited, class Whole>
void expect_limited(unsigned seed, int bits, Limited&& limited, Whole&& whole) {
  const std::int64_t end = std::int64_t{1} << (32 + bits);
  std::mt19937_64 random(seed);
  int within = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto a = Fixed::from_raw(any_raw(random)), b = Fixed::from_raw(any_raw(random));
    if (b == Fixed(0)) continue;
    const std::uint32_t before = Fixed::saturations();
    const std::int64_t got = limited(a, b).raw();
    ASSERT_EQ(Fixed::saturations(), before);
    ASSERT_EQ(got, std::clamp(whole(a, b).raw(), -end, end)) << "of " << a.raw() << " and " << b.raw();
    if (std::abs(got) < end && got != 0) ++within;
  }
  EXPECT_GT(within, 20'000);
}

TEST(Fixed, RatiosWithinAPowerOfTwoEndThereAndAreNotCounted) {
  constexpr int kBits = 4;
  expect_limited(
      7, kBits, [](Fixed a, Fixed b) { return ratio_within<kBits>(a, b); }, std::divides<>());
  constexpr std::int64_t kEnd = std::int64_t{1} << (32 + kBits);
  EXPECT_EQ(ratio_within<kBits>(Fixed(3), Fixed(0)).raw(), kEnd);
  EXPECT_EQ(ratio_within<kBits>(Fixed(-3), Fixed(0)).raw(), -kEnd);
  EXPECT_EQ(ratio_within<kBits>(Fixed(0), Fixed(0)).raw(), 0);
}

TEST(Fixed, ProductsWithinAPowerOfTwoEndThereAndAreNotCounted) {
  constexpr int kBits = 28;
  expect_limited(
      8, kBits, [](Fixed a, Fixed b) { return product_within<kBits>(a, b); }, std::multiplies<>());
  EXPECT_EQ(product_within<kBits>(Fixed(3), Fixed(0)).raw(), 0);
}

TEST(Fixed, RootsAreTheNearest) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 2'000'000; ++i) {
    const std::int64_t raw = std::abs(any_raw(random));
    const Wide of = Wide{raw} << 32, twice = 2 * Wide{sqrt(Fixed::from_raw(raw)).raw()};
    const Wide half = raw < std::int64_t{1} << 56 ? 1 : 32;  // an ulp or 16, of twice the root
    ASSERT_LE(twice < half ? 0 : (twice - half) * (twice - half), 4 * of) << raw;
    ASSERT_GE((twice + half) * (twice + half), 4 * of) << raw;
  }
}

TEST(Fixed, PartsOfANumberAreTheExactOnesRounded) {
  std::mt19937_64 random(6);
  for (int i = 0; i < 2'000'000; ++i) {
    const std::int64_t a = any_raw(random);
    const auto part = static_cast<std::uint32_t>(random() >> 32U >> random() % 32);
    const auto exact = static_cast<std::int64_t>((Wide{a} * part + (Wide{1} << 31)) >> 32);
    ASSERT_EQ((Fixed::from_raw(a) * Fraction(part)).raw(), exact) << a << " * " << part;
  }
}

TEST(Fixed, AtTheEndsOfTheRangeNothingGoesRound) {
  for (const std::int64_t a :
       {kLeast, kLeast + 1, std::int64_t{-1}, std::int64_t{0}, std::int64_t{1}, kMost}) {
    for (const std::int64_t b :
         {kLeast, kLeast + 1, std::int64_t{-1}, std::int64_t{0}, std::int64_t{1}, kMost}) {
      const Fixed x = Fixed::from_raw(a), y = Fixed::from_raw(b);
      EXPECT_EQ((x + y).raw(), cut(Wide{a} + b)) << a << " + " << b;
      EXPECT_EQ((x - y).raw(), cut(Wide{a} - b)) << a << " - " << b;
      EXPECT_EQ((x * y).raw(), cut((Wide{a} * b + (Wide{1} << 31)) >> 32)) << a << " * " << b;
      EXPECT_EQ(Fixed::product_by_parts(a, b), (x * y).raw()) << a << " * " << b;
      EXPECT_EQ((-x).raw(), cut(-Wide{a})) << a;
    }
  }
}
#endif

TEST(Fixed, InverseRootsAreWithinWhatIsStated) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 2'000'000; ++i) {
    const auto raw = static_cast<std::int64_t>(random() >> 1U >> random() % 62 | 1U);
    const long double exact = kUlps * std::sqrt(kUlps / static_cast<long double>(raw));
    ASSERT_NEAR(
        static_cast<double>(static_cast<long double>(inverse_sqrt(Fixed::from_raw(raw)).raw()) - exact), 0.0,
        static_cast<double>(exact * 0x1p-28L + 1.0L))
        << raw;
  }
}

TEST(Fixed, WhatDoesNotFitIsCountedAndWhatFitsIsNot) {
  volatile std::int64_t most = kMost;  // seen at run time
  const Fixed largest = Fixed::from_raw(most);
  EXPECT_TRUE(counts([&] { EXPECT_EQ((largest + Fixed::from_raw(1)).raw(), kMost); }));
  EXPECT_TRUE(counts([&] { EXPECT_EQ((-largest - Fixed(1)).raw(), kLeast); }));
  EXPECT_TRUE(counts([&] { EXPECT_EQ((largest * Fixed(-2)).raw(), kLeast); }));
  EXPECT_TRUE(counts([&] { EXPECT_EQ((largest / Fixed(0.5)).raw(), kMost); }));
  EXPECT_FALSE(counts([&] { EXPECT_EQ((largest - largest).raw(), 0); }));
  EXPECT_FALSE(counts([&] { EXPECT_EQ((largest * Fixed(1)).raw(), kMost); }));
}

TEST(Fixed, NothingIsDividedByNothingAndNoRootIsTakenOfLess) {
  EXPECT_TRUE(counts([] { EXPECT_EQ((Fixed(3) / Fixed(0)).raw(), kMost); }));
  EXPECT_TRUE(counts([] { EXPECT_EQ((Fixed(-3) / Fixed(0)).raw(), kLeast); }));
  EXPECT_TRUE(counts([] { EXPECT_EQ((Fixed(0) / Fixed(0)).raw(), 0); }));
  EXPECT_TRUE(counts([] { EXPECT_EQ(sqrt(Fixed(-1)).raw(), 0); }));
  EXPECT_TRUE(counts([] { EXPECT_EQ(inverse_sqrt(Fixed(0)).raw(), 0); }));
  EXPECT_FALSE(counts([] { EXPECT_EQ((Fixed(0) / Fixed(3)).raw(), 0); }));
  EXPECT_FALSE(counts([] { EXPECT_EQ(sqrt(Fixed(0)).raw(), 0); }));
}

TEST(Fixed, TakesTheNearestOfEveryFloat) {
  std::mt19937 random(3);
  for (int i = 0; i < 2'000'000; ++i) {
    const float x = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!std::isfinite(x)) continue;
    const double scaled = std::round(std::ldexp(static_cast<double>(x), 32));  // exact: 24 bits
    const std::int64_t nearest = scaled >= 0x1p63   ? kMost
                                 : scaled < -0x1p63 ? kLeast
                                                    : static_cast<std::int64_t>(scaled);
    ASSERT_EQ(Fixed(x).raw(), nearest) << x;
    ASSERT_EQ(Fixed(static_cast<double>(x)).raw(), nearest) << x;
  }
}

TEST(Fixed, TakesNoNumberForNothingAndTheInfiniteForItsEnds) {
  EXPECT_TRUE(counts([] { EXPECT_EQ(Fixed(std::numeric_limits<float>::quiet_NaN()).raw(), 0); }));
  EXPECT_TRUE(counts([] { EXPECT_EQ(Fixed(std::numeric_limits<float>::infinity()).raw(), kMost); }));
  EXPECT_TRUE(counts([] { EXPECT_EQ(Fixed(-std::numeric_limits<float>::infinity()).raw(), kLeast); }));
  EXPECT_TRUE(counts([] { EXPECT_EQ(Fixed(std::uint64_t{1} << 40U).raw(), kMost); }));
  EXPECT_EQ(Fixed(-7).raw(), -(std::int64_t{7} << 32U));
}

TEST(Fixed, GivesBackTheFloatsThatItHolds) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> voltage(-1000.0F, 1000.0F);
  for (int i = 0; i < 100'000; ++i) {
    const float x = std::round(voltage(random) * 0x1p13F) * 0x1p-13F;
    ASSERT_EQ(static_cast<float>(Fixed(x)), x);
  }
  EXPECT_EQ(static_cast<int>(Fixed(-2.75)), -2) << "towards zero";
  EXPECT_EQ(static_cast<int>(Fixed(2.75)), 2);
}

TEST(FixedDecay, IsOneMinusExpWithinTwoAndAHalfUnitsFromEndToEnd) {
  long double worst = 0;
  std::int64_t worst_raw = 0;
  for (std::int64_t raw = 1; raw < (std::int64_t{25} << 32U); raw += 53'987) {
    const long double exact = -std::expm1(-static_cast<long double>(raw) / kUlps) * kUlps;
    const long double error = std::fabs(static_cast<long double>(decay(Fixed::from_raw(raw)).raw()) - exact);
    if (error > worst) {
      worst = error;
      worst_raw = raw;
    }
  }
  EXPECT_LT(worst, 2.5L) << "ulp, at raw " << worst_raw;
}

TEST(FixedDecay, IsClampedAtTheEndsOfItsRange) {
  EXPECT_EQ(decay(Fixed(0)), Fixed(0));
  EXPECT_EQ(decay(Fixed(-1)), Fixed(0)) << "a negative rate does nothing";
  EXPECT_EQ(decay(Fixed(kDecayHigh)), Fixed(1));
  EXPECT_EQ(decay(Fixed::from_raw(kMost)), Fixed(1));
}

TEST(FixedDecay, OfManyIsThatOfEach) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> gain(-3.0, 7.0), shift(-2.0, 2.0);
  std::uniform_int_distribution<std::uint32_t> k;
  std::array<Fraction, 32> of, done;
  for (int i = 0; i < 50'000; ++i) {
    const Fixed a = std::exp(gain(random)), b = shift(random);
    for (Fraction& x : of) x = Fraction(k(random));
    decays(a, b, of, done);
    for (std::size_t n = 0; n < of.size(); ++n) {
      const auto exactly = [](Fixed x) { return static_cast<long double>(x.raw()) / kUlps; };
      const long double x = exactly(a) * exactly(of[n]) + exactly(b);
      const long double exact = x < 0 ? 0.0L : -std::expm1(-x) * kUlps;
      ASSERT_NEAR(static_cast<double>(static_cast<long double>(Fixed(done[n]).raw()) - exact), 0.0, 3.5)
          << "ulp, of " << static_cast<double>(a) << " * " << static_cast<double>(Fixed(of[n])) << " + "
          << static_cast<double>(b);
    }
  }
}

TEST(FixedDecay, OfManyPassesNoRange) {
  const std::array<Fraction, 2> of = {Fraction(1), Fraction(0xFFFFFFFFU)};
  std::array<Fraction, 2> done;
  for (const std::int64_t shift : {kLeast, kMost}) {
    decays(Fixed::from_raw(kMost), Fixed::from_raw(shift), of, done);
    EXPECT_EQ(done[1].raw(), shift < 0 ? 0U : 0xFFFFFFFFU) << "the least and the most cancel";
  }
  decays(Fixed(3), Fixed::from_raw(kLeast), of, done);
  EXPECT_EQ(done[0].raw(), 0U);
}

TEST(FixedDecay, OfManyCountsAGainAndAShiftThatAreHeld) {
  const std::array<Fraction, 1> of = {Fraction(0x80000000U)};
  std::array<Fraction, 1> done;
  const Fixed most = 372'130'000;  // times log2 e: below 2^29, which a thousandth more is not
  for (const Fixed x : {most, Fixed(0) - most})
    EXPECT_FALSE(counts([&] { decays(x, x, of, done); })) << static_cast<double>(x);
  for (const Fixed x : {most * Fixed(1.001), most * Fixed(-1.001)}) {
    EXPECT_EQ(counted([&] { decays(x, Fixed(1), of, done); }), 1U) << static_cast<double>(x);
    EXPECT_EQ(counted([&] { decays(Fixed(1), x, of, done); }), 1U) << static_cast<double>(x);
  }
}

TEST(FixedDecay, AsAPartIsTheSameButForTheLastUnit) {
  for (std::int64_t raw = -5; raw < (std::int64_t{25} << 32U); raw += 539'873) {
    const Fixed x = Fixed::from_raw(raw);
    const Fraction part = decay_part(x);
    const std::int64_t less = decay(x).raw() - Fixed(part).raw();
    ASSERT_TRUE(less == 0 || less == 1) << "raw " << raw;
    ASSERT_EQ(Fixed(rest_of(part)).raw() + Fixed(part).raw(), 0xFFFFFFFF);
  }
  EXPECT_EQ(decay_part(Fixed(0)).raw(), 0U);
}

TEST(FixedPart, IsTheNearestOfAWholeThatIsAPowerOfTwo) {
  EXPECT_EQ(whole_above(Fixed(0)), Fixed(1));
  EXPECT_EQ(whole_above(Fixed(1)), Fixed(2));
  EXPECT_EQ(whole_above(Fixed(15.999)), Fixed(16));
  EXPECT_EQ(whole_above(Fixed::from_raw(kMost)), Fixed(1 << 30));
  EXPECT_EQ(part_of(Fixed(4), Fixed(16)).raw(), 0x40000000U);
  EXPECT_EQ(part_of(Fixed::from_raw(9), Fixed(16)).raw(), 1U);
  EXPECT_EQ(part_of(Fixed(16), Fixed(16)).raw(), 0xFFFFFFFFU) << "no more than there is";
  EXPECT_EQ(part_of(Fixed(-1), Fixed(16)).raw(), 0U);
}

TEST(FixedShift, IsTheProductWithThePowerOfTwo) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 100'000; ++i) {
    const Fixed x = Fixed::from_raw(static_cast<std::int64_t>(random()) >> (i % 40));
    ASSERT_EQ(shifted_down<1>(x), x * Fixed(0.5)) << "raw " << x.raw();
    ASSERT_EQ(shifted_down<17>(x), x * Fixed(0x1p-17)) << "raw " << x.raw();
  }
}

TEST(FixedThousandth, IsWithinAnUlpAndThreeTenBillionths) {
  std::mt19937_64 random(10);
  for (int i = 0; i < 100'000; ++i) {
    const std::int64_t raw = static_cast<std::int64_t>(random()) >> (i % 60);
    const long double exact = static_cast<long double>(raw) / 1000;
    const long double found = static_cast<long double>(thousandth(Fixed::from_raw(raw)).raw());
    ASSERT_LE(std::abs(found - exact), 1 + 3e-10L * std::abs(exact)) << "raw " << raw;
  }
  for (const float set_Pa : {100'000.0F, 123'456.0F, 350'000.0F, 3'276'700.0F}) {
    EXPECT_EQ(static_cast<float>(thousandth(Fixed(set_Pa))), set_Pa / 1000) << "a float sees no error";
  }
}

TEST(FixedShares, AreTheProductsLessAnotherAndPassNoRangeButWhatIsHeldIsCounted) {
  const std::array<Fixed, 2> of = {Fixed(300), Fixed(-(1 << 29))};
  const std::array<Fraction, 2> part = {Fraction(0x80000000U), Fraction(0xFFFFFFFFU)};
  std::array<Fixed, 2> share;
  shares(of, Fixed(-100.5), part, Fixed(0.25), share);
  EXPECT_EQ(share[0], Fixed(99.5));
  EXPECT_FALSE(counts([&] { shares(of, Fixed(1 << 29), part, Fixed(-(1 << 29)), share); }));
  EXPECT_EQ(counted([&] { shares(of, Fixed::from_raw(kLeast), part, Fixed::from_raw(kMost), share); }), 2U)
      << "what is added and what is taken off are held";
  EXPECT_LT(share[0], Fixed(-(1 << 28)));
  EXPECT_LT(share[1], Fixed(-(1 << 30)));
}

TEST(FixedLog, IsTheLogarithmOfWhateverIsPositive) {
  for (long double x = 3e-9L; x < 2e9L; x *= 1.000731L) {
    const Fixed at = Fixed(static_cast<double>(x));
    const long double exact = std::log(static_cast<long double>(at.raw()) / kUlps);
    const long double error = std::fabs(static_cast<long double>(log(at).raw()) / kUlps - exact);
    ASSERT_LE(error, 2e-9L + 3e-10L * std::fabs(exact)) << "x = " << static_cast<double>(x);
  }
}

TEST(FixedPhi, AreTheFunctionsOfAnExponentialStepForEitherSign) {
  for (double x = -4.0; x < 30.0; x += 0.000713) {
    const Fixed at = Fixed(x);
    const long double wide = static_cast<long double>(at.raw()) / kUlps;
    const long double exact = -std::expm1(-wide) / wide;
    const Fixed first = phi_1(at);
    ASSERT_NEAR(static_cast<double>(static_cast<long double>(first.raw()) / kUlps / exact), 1.0, 4e-8)
        << "x = " << x;
    const long double exact_2 = (1.0L - exact) / wide;
    if (std::abs(x) < 1e-3) continue;  // where that is no oracle
    ASSERT_NEAR(static_cast<double>(static_cast<long double>(phi_2(at, first).raw()) / kUlps / exact_2), 1.0,
                1e-6)
        << "x = " << x;
  }
  EXPECT_EQ(phi_1(Fixed(0)), Fixed(1));
  EXPECT_EQ(phi_1(Fixed(-100)), phi_1(Fixed(-kGrowthHigh))) << "a growth is followed so far";
}

}  // namespace
}  // namespace plenum::numeric
