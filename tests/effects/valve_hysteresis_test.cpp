// valve_hysteresis: its loops, against closed forms.
#include <gtest/gtest.h>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

ValveHysteresis<double> play_of(double width_V, double rounding = 0.0, double reach = 2.0,
                                double letting_go = 1.0) {
  const double x[] = {width_V, rounding, reach, letting_go};
  ValveHysteresis<double> play;
  play.prepare(x, 5.0);
  return play;
}

TEST(ValveHysteresis, LoopHasItsWidthAtEveryPlaceAndAtAnyRate) {
  for (const double step_V : {0.01, 0.37}) {
    ValveHysteresis<double> play = play_of(0.3);
    const auto sweep = [&](double from_V, double to_V, double offset_V) {
      const double direction = to_V > from_V ? 1.0 : -1.0;
      for (double u = from_V; direction * (to_V - u) > 0.0; u += direction * step_V) {
        const double x = play.follow(u);
        if (std::abs(u - from_V) > 0.3) {
          ASSERT_DOUBLE_EQ(x, u + offset_V) << "V at command " << u;
        }
      }
    };
    sweep(5.0, 8.0, -0.15);
    sweep(8.0, 2.0, +0.15);
    sweep(2.0, 8.0, -0.15);
  }
}

TEST(ValveHysteresis, ReversalWithinTheWidthMovesNothing) {
  ValveHysteresis<double> play = play_of(0.4);
  const double stuck_V = play.follow(6.0);
  EXPECT_DOUBLE_EQ(stuck_V, 5.8);
  for (const double u : {5.9, 5.7, 5.61, 5.99, 5.75}) EXPECT_EQ(play.follow(u), stuck_V);
  EXPECT_DOUBLE_EQ(play.follow(5.5), 5.7);
}

TEST(ValveHysteresis, RoundedCornerIsDahlsExponential) {
  // swept up far, then back: z runs from 1 to -1 as 2 e^(-s/(d w/2)) - 1 over the way s
  for (const double step_V : {0.01, 0.09}) {
    ValveHysteresis<double> play = play_of(0.2, 1.0, 2.5);
    for (double u = 5.0; u < 8.0; u += step_V) play.follow(u);
    play.follow(8.0);
    for (double way_V = step_V; way_V < 1.0; way_V += step_V) {
      const double creep = 2.0 * std::exp(-way_V / (2.5 * 0.1)) - 1.0;
      ASSERT_NEAR(play.follow(8.0 - way_V), 8.0 - way_V - 0.1 * creep, 1e-5) << "V, back by " << way_V;
    }
  }
}

TEST(ValveHysteresis, LetsGoAsBoucAndWenSay) {
  // swept up far, z = 1, then back by s: z' = -1 - (2 b - 1) z over l = s/(d b w/2) until z = 0, then z' = -1 - z
  constexpr double kWidth_V = 0.2, kReach = 2.5;
  for (const double b : {0.5, 0.75, 0.999}) {
    const double yielding = 2.0 * b - 1.0;
    const auto friction = [&](double way_V) {
      const double way = way_V / (kReach * b * 0.5 * kWidth_V);
      const double free = yielding > 0.0 ? std::log1p(yielding) / yielding : 1.0;
      if (way > free) return std::exp(free - way) - 1.0;
      return yielding > 0.0 ? ((1.0 + yielding) * std::exp(-yielding * way) - 1.0) / yielding : 1.0 - way;
    };
    for (const double step_V : {0.01, 0.09, 0.8}) {
      ValveHysteresis<double> play = play_of(kWidth_V, 1.0, kReach, b);
      for (double u = 5.0; u < 9.0; u += step_V) play.follow(u);
      play.follow(9.0);
      for (double way_V = step_V; way_V < 1.0; way_V += step_V) {
        ASSERT_NEAR(play.follow(9.0 - way_V), 9.0 - way_V - 0.5 * kWidth_V * friction(way_V), 1e-6)
            << "V, back by " << way_V << " in steps of " << step_V << ", b " << b;
      }
    }
  }
}

TEST(ValveHysteresis, LettingGoInProportionHoldsTheSpoolUntilTheFrictionIsGone) {
  // b = 1/2, d = 2: the friction falls as fast as the command, so nothing moves over half the width
  ValveHysteresis<double> play = play_of(0.4, 1.0, 2.0, 0.5);
  const double end_V = play.follow(9.0);
  for (const double u : {8.95, 8.9, 8.81}) EXPECT_NEAR(play.follow(u), end_V, 1e-6) << "V at command " << u;
  EXPECT_LT(play.follow(8.7), end_V - 0.02);
}

/// A loop of 0.2 V is as wide as the play's, and its spool never moves against the command.
void expect_passive_loop(ValveHysteresis<double> play) {
  double before_V = play.follow(5.0);
  for (int k = 1; k <= 800; ++k) {
    const double up = k <= 400 ? 1.0 : -1.0;
    const double u = 5.0 + 0.005 * (k <= 400 ? k : 800 - k);
    const double place_V = play.follow(u);
    ASSERT_GE(up * (place_V - before_V), -1e-12) << "V, command " << u;
    if (k == 400 || k == 800) {
      EXPECT_NEAR(place_V, u - up * 0.1, 1e-4) << "V";
    }
    before_V = place_V;
  }
}

TEST(ValveHysteresis, RoundedLoopIsAsWideAsThePlayAndNeverMovesAgainstItsCommand) {
  for (const double b : {1.0, 0.8, 0.5}) {
    SCOPED_TRACE(b);
    expect_passive_loop(play_of(0.2, 0.6, 2.0, b));
  }
}

TEST(ValveHysteresis, WithoutWidthTheSpoolIsWhereItsCommandIs) {
  ValveHysteresis<double> play = play_of(0.0);
  for (const double u : {5.0, 7.3, 2.0, 2.0, 9.9}) EXPECT_EQ(play.follow(u), u);
}

}  // namespace
}  // namespace plenum::host::effects
