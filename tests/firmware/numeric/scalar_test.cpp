// The scalar functions of the core against the C library in long double.
#include "firmware/numeric/scalar.hpp"
#include "firmware/numeric/nearest.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plenum::numeric {
namespace {

TEST(Decay, IsOneMinusExpWithinThreeTenMillionthsFromEndToEnd) {
  double worst = 0;
  double worst_x = 0;
  for (int i = 1; i <= 2'400'000; ++i) {
    const float x = static_cast<float>(i * 1e-5);
    const double exact = static_cast<double>(-std::expm1(-static_cast<long double>(x)));
    const double error = std::fabs((static_cast<double>(decay(x)) - exact) / exact);
    if (error > worst) {
      worst = error;
      worst_x = static_cast<double>(x);
    }
  }
  EXPECT_LT(worst, 3e-7) << "relative error at x = " << worst_x;
}

TEST(Decay, DoesNotCancelNearZero) {
  for (float x = 1e-30F; x < 1e-2F; x *= 1.7F) {
    const double exact = static_cast<double>(-std::expm1(-static_cast<long double>(x)));
    EXPECT_NEAR(static_cast<double>(decay(x)) / exact, 1.0, 3e-7) << "x = " << x;
  }
  EXPECT_EQ(decay(0.0F), 0.0F);
}

TEST(Decay, IsClampedAtTheEndsOfItsRange) {
  EXPECT_EQ(decay(float{kDecayHigh}), 1.0F);
  EXPECT_EQ(decay(1e30F), 1.0F);
  EXPECT_EQ(decay(std::numeric_limits<float>::infinity()), 1.0F);
  EXPECT_EQ(decay(-1e-3F), 0.0F) << "a negative rate does nothing";
  EXPECT_EQ(decay(-1e30F), 0.0F);
  EXPECT_EQ(decay(std::numeric_limits<float>::quiet_NaN()), 0.0F) << "a converted not-a-number is undefined";
}

TEST(Decay, RisesEverywhere) {
  float previous = decay(0.0F);
  for (int i = 1; i <= 240'000; ++i) {
    const float now = decay(static_cast<float>(i * 1e-4));
    EXPECT_GE(now, previous * (1.0F - 2e-7F)) << "x = " << i * 1e-4;
    previous = now;
  }
}

TEST(MeanDecay, IsTheMeanOfTheExponentialOverTheTick) {
  for (double x = 1e-6; x < 300.0; x += 0.00371) {
    const float at = static_cast<float>(x);
    const long double wide = static_cast<long double>(at);
    const double exact = static_cast<double>(-std::expm1(-wide) / wide);
    EXPECT_NEAR(static_cast<double>(mean_decay(at, decay(at))) / exact, 1.0, 4e-7) << "x = " << x;
  }
  EXPECT_EQ(mean_decay(0.0F, decay(0.0F)), 1.0F);
  EXPECT_EQ(mean_decay(-1.0F, decay(-1.0F)), 1.0F);
}

TEST(Phi, AreTheFunctionsOfAnExponentialStepForEitherSign) {
  for (double x = -4.0; x < 40.0; x += 0.000713) {
    const float at = static_cast<float>(x);
    const long double wide = static_cast<long double>(at);
    const long double exact = -std::expm1(-wide) / wide;
    const float first = phi_1(at);
    // of a growth e^-|x| = 1 - decay, which is known to a unit in the last place of 1
    const double rounding = 4e-7 + (x < 0.0 ? 6e-8 * std::exp(-x) : 0.0);
    EXPECT_NEAR(static_cast<double>(static_cast<long double>(first) / exact), 1.0, rounding) << "x = " << x;
    // (1 - phi_1)/x cancels down to the ends of its series
    const long double exact_2 = (1.0L - exact) / wide;
    if (std::abs(x) < 1e-3) continue;  // where that is no oracle
    EXPECT_NEAR(static_cast<double>(static_cast<long double>(phi_2(at, first)) / exact_2), 1.0,
                rounding + 5e-6)
        << "x = " << x;
  }
  EXPECT_EQ(phi_1(0.0F), 1.0F);
  EXPECT_EQ(phi_2(0.0F, 1.0F), 0.5F);
  EXPECT_EQ(phi_1(-1e30F), phi_1(float{-kGrowthHigh})) << "a growth is followed so far";
}

TEST(IsFinite, TellsNumbersFromTheRest) {
  EXPECT_TRUE(is_finite(0.0F));
  EXPECT_TRUE(is_finite(std::numeric_limits<float>::max()));
  EXPECT_FALSE(is_finite(std::numeric_limits<float>::infinity()));
  EXPECT_FALSE(is_finite(-std::numeric_limits<float>::infinity()));
  EXPECT_FALSE(is_finite(std::numeric_limits<float>::quiet_NaN()));
}

TEST(Nearest, IsTheWholeNumberAtHandATieAwayFromZero) {
  for (int code = -3000; code <= 3000; ++code) {
    const auto at = static_cast<float>(code);
    EXPECT_EQ(nearest_within(at, -32767, 32767, 7), code);
    EXPECT_EQ(nearest_within(at + 0.25F, -32767, 32767, 7), code);
    EXPECT_EQ(nearest_within(at - 0.25F, -32767, 32767, 7), code);
    EXPECT_EQ(nearest_within(at + 0.5F, -32767, 32767, 7), code < 0 ? code : code + 1);
  }
}

TEST(Nearest, IsCutOffAtTheLimitsAndKnowsWhatIsNoNumber) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float beyond : {70'000.0F, 0x1p22F, 0x1p31F, 3e38F, kInfinity}) {
    EXPECT_EQ(nearest_within(beyond, 0, 65535, 7), 65535) << beyond;
    EXPECT_EQ(nearest_within(-beyond, 0, 65535, 7), 0) << beyond;
    EXPECT_EQ(nearest_within(-beyond, -32767, 32767, 7), -32767) << beyond;
  }
  for (const float none :
       {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_EQ(nearest_within(none, 0, 65535, 7), 7);
  }
}

TEST(Nearest, OfAFixedIsTheSameAndFromLimitToLimit) {
  constexpr std::int64_t kUlp = 1;
  for (int code = -3000; code <= 3000; ++code) {
    const Fixed at = code;
    const Fixed tie = at + Fixed(0.5);
    EXPECT_EQ(nearest_within(at, -32767, 32767, 7), code);
    EXPECT_EQ(nearest_within(tie, -32767, 32767, 7), code < 0 ? code : code + 1);
    EXPECT_EQ(nearest_within(Fixed::from_raw(tie.raw() - kUlp), -32767, 32767, 7), code);
    EXPECT_EQ(nearest_within(Fixed::from_raw(tie.raw() + kUlp), -32767, 32767, 7), code + 1);
  }
  EXPECT_EQ(nearest_within(Fixed(65534.5), 0, 65535, 7), 65535);
  EXPECT_EQ(nearest_within(Fixed(-0.75), 0, 65535, 7), 0);
  for (const Fixed beyond : {Fixed(70'000), Fixed::from_raw(std::numeric_limits<std::int64_t>::max())}) {
    EXPECT_EQ(nearest_within(beyond, 0, 65535, 7), 65535);
    EXPECT_EQ(nearest_within(-beyond, 0, 65535, 7), 0);
    EXPECT_EQ(nearest_within(-beyond, -32767, 32767, 7), -32767);
  }
}

TEST(PlaceOf, OrdersEveryTwoNumbersAsTheyAreAndPutsWhatIsNoneAtTheEnds) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float some[] = {-kInfinity, -3e38F, -1.5F, -1.0F, -1e-45F, -0.0F,   0.0F,
                        1e-45F,     1e-38F, 0.2F,  9.9F,  10.1F,   3.3e38F, kInfinity};
  for (const float a : some) {
    for (const float b : some) {
      EXPECT_EQ(place_of(a) < place_of(b), a < b) << a << " and " << b;
      EXPECT_EQ(place_of(a) == place_of(b), a == b) << a << " and " << b;
    }
  }
  EXPECT_GT(place_of(std::numeric_limits<float>::quiet_NaN()), place_of(kInfinity));
  EXPECT_LT(place_of(-std::numeric_limits<float>::quiet_NaN()), place_of(-kInfinity));
}

}  // namespace
}  // namespace plenum::numeric
