// What the board's numbers make of operands that err, against exact results in long double: within what a Rounded says, for every
// operation of a step.
#include "host-sim/rounding/rounded.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "firmware/numeric/scalar.hpp"

namespace plenum::numeric {
namespace {

using Exact = long double;

Exact exact(Fixed x) {
  return std::ldexp(static_cast<Exact>(x.raw()), -32);
}

/// A box of exact numbers, one of them, and what a board may have for it.
struct Drawn {
  Rounded box;
  Exact number;
  Fixed on_board;
};

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  /// Within [low, high]: a point or a part of it, with an error from none to a thousand ulps.
  Drawn draw(double low, double high) {
    double from = uniform(low, high), to = from;
    if (uniform(0, 1) < 0.5) to = uniform(from, high);
    const double ulps = uniform(0, 1) < 0.3 ? 0.5 : std::pow(10.0, uniform(0, 3));
    const double number = uniform(from, to);
    const double apart = (ulps - 0.5) * Rounded::kUlp;
    const Fixed on_board = Fixed(number + uniform(-apart, apart));  // nearest: half an ulp more
    return {.box = Rounded(from, to, ulps * Rounded::kUlp),
            .number = static_cast<Exact>(number),
            .on_board = on_board};
  }

 private:
  std::mt19937_64 engine_;
};

void expect_held(const Rounded& bound, Exact number, Fixed on_board, const char* of) {
  ASSERT_LE(static_cast<Exact>(bound.low()), number) << of;
  ASSERT_GE(static_cast<Exact>(bound.high()), number) << of;
  ASSERT_LE(std::fabs(exact(on_board) - number), static_cast<Exact>(bound.error()))
      << of << " of " << static_cast<double>(number) << " in " << bound.low() << " .. " << bound.high();
}

constexpr int kDraws = 200'000;

template <class OnBoard, class InExact, class AsRounded>
void expect_one_held(const char* of, double low, double high, OnBoard on_board, InExact in_exact,
                     AsRounded as_rounded) {
  Random random(1);
  for (int i = 0; i < kDraws && !::testing::Test::HasFatalFailure(); ++i) {
    const Drawn x = random.draw(low, high);
    expect_held(as_rounded(x.box), in_exact(x.number), on_board(x.on_board), of);
  }
}

TEST(Rounded, HoldsSumsProductsAndQuotients) {
  Random random(2);
  for (int i = 0; i < kDraws && !HasFatalFailure(); ++i) {
    const double size = std::pow(10.0, random.uniform(-2, 4));
    const Drawn a = random.draw(-size, size), b = random.draw(-100, 100), d = random.draw(0.01, 1000);
    expect_held(a.box + b.box, a.number + b.number, a.on_board + b.on_board, "+");
    expect_held(a.box - b.box, a.number - b.number, a.on_board - b.on_board, "-");
    expect_held(a.box * b.box, a.number * b.number, a.on_board * b.on_board, "*");
    expect_held(a.box * a.box, a.number * a.number, a.on_board * a.on_board, "square");
    expect_held(a.box / d.box, a.number / d.number, a.on_board / d.on_board, "/");
    expect_held(a.box / -d.box, a.number / -d.number, a.on_board / -d.on_board, "/ of less than 0");
    expect_held(near_ratio(a.box, d.box), a.number / d.number, near_ratio(a.on_board, d.on_board),
                "near_ratio");
    expect_held(clamp(a.box, Rounded(-5), b.box), std::min(std::max(a.number, Exact(-5)), b.number),
                min(max(a.on_board, Fixed(-5)), b.on_board), "clamp");
  }
}

TEST(Rounded, HoldsAPartOfAWhole) {
  Random random(3);
  for (int i = 0; i < kDraws && !HasFatalFailure(); ++i) {
    const Drawn x = random.draw(0, 30), of = random.draw(-700, 700);
    expect_held(of.box * decay(x.box), of.number * -std::expm1(-x.number),
                of.on_board * decay_part(x.on_board), "product with a part");
  }
}

Exact exact_phi_1(Exact x) {
  return std::fabs(x) < 1e-12L ? 1 - x / 2 : -std::expm1(-x) / x;
}
Exact exact_phi_2(Exact x) {
  constexpr Exact kSeries = 0.03L;
  if (std::fabs(x) >= kSeries) return (1 - exact_phi_1(x)) / x;
  Exact sum = 0;
  for (int n = 12; n > 0; --n) {  // of (-x)^(n-1)/(n+1)!
    Exact term = 1;
    for (int k = 2; k <= n + 1; ++k) term /= k;
    sum += term * std::pow(-x, n - 1);
  }
  return sum;
}

TEST(Rounded, HoldsTheFunctionsOfAStep) {
  expect_one_held(
      "sqrt", 1e-6, 1e4, [](Fixed x) { return sqrt(x); }, [](Exact x) { return std::sqrt(x); },
      [](const Rounded& x) { return sqrt(x); });
  expect_one_held(
      "inverse_sqrt", 1, 4e6, [](Fixed x) { return inverse_sqrt(x); },
      [](Exact x) { return 1 / std::sqrt(x); }, [](const Rounded& x) { return inverse_sqrt(x); });
  for (const double reach : {0.01, 1.0, 40.0}) {
    expect_one_held(
        "decay", -0.2 * reach, reach, [](Fixed x) { return decay(x); },
        [](Exact x) { return -std::expm1(-std::max(x, Exact(0))); },
        [](const Rounded& x) { return decay(x); });
    expect_one_held(
        "mean_decay", -0.2 * reach, reach, [](Fixed x) { return mean_decay(x, Fixed(decay_part(x))); },
        [](Exact x) { return exact_phi_1(std::max(x, Exact(0))); },
        [](const Rounded& x) { return mean_decay(x, decay(x)); });
    expect_one_held(
        "phi_1", -0.2 * reach, reach, [](Fixed x) { return phi_1(x); },
        [](Exact x) { return exact_phi_1(std::max(x, Exact(-4))); },
        [](const Rounded& x) { return phi_1(x); });
    expect_one_held(
        "phi_2", -0.2 * reach, reach, [](Fixed x) { return phi_2(x, phi_1(x)); },
        [](Exact x) { return exact_phi_2(std::max(x, Exact(-4))); },
        [](const Rounded& x) { return phi_2(x, phi_1(x)); });
  }
}

TEST(Rounded, TakesAConstantOverAsTheBoardDoes) {
  EXPECT_EQ(Rounded(0.5).error(), 0);
  EXPECT_EQ(Rounded(0x1p-32).error(), 0);
  EXPECT_EQ(Rounded(1.0 / 6).error(), Rounded::kHalfUlp);
}

TEST(Rounded, RefusesAComparisonThatRoundingMayTurn) {
  const Rounded one(1.0, 1.0, 1e-9), next(1.0 + 1e-9, 1.0 + 1e-9, 1e-9), far(1.1);
  EXPECT_THROW(static_cast<void>(one < next), std::logic_error);
  EXPECT_TRUE(one < far);
  EXPECT_FALSE(far < one);
}

}  // namespace
}  // namespace plenum::numeric
