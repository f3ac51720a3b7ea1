// valve_hysteresis: its loops, against closed forms.
#include <gtest/gtest.h>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

constexpr double kPlay_V = 1e-6;  ///< what the play is known to

ValveHysteresis<double> loop_of(double width_V, double softness = 0.0, double spring = 1.0,
                                double letting_go = 1.0) {
  const double x[] = {width_V, softness, spring, letting_go};
  ValveHysteresis<double> loop;
  loop.prepare(x, 5.0);
  return loop;
}

/// The same after a sweep up to 9 V, by which the friction is at its greatest.
ValveHysteresis<double> swept_up(double width_V, double softness, double spring, double letting_go) {
  ValveHysteresis<double> loop = loop_of(width_V, softness, spring, letting_go);
  loop.follow(9.0);
  return loop;
}

TEST(ValveHysteresis, LoopHasItsWidthAtEveryPlaceAndAtAnyRate) {
  for (const double step_V : {0.01, 0.37}) {
    ValveHysteresis<double> loop = loop_of(0.3);
    const auto sweep = [&](double from_V, double to_V, double offset_V) {
      const double direction = to_V > from_V ? 1.0 : -1.0;
      for (double u = from_V; direction * (to_V - u) > 0.0; u += direction * step_V) {
        const double x = loop.follow(u);
        if (std::abs(u - from_V) > 0.3) {
          ASSERT_NEAR(x, u + offset_V, kPlay_V) << "V at command " << u;
        }
      }
    };
    sweep(5.0, 8.0, -0.15);
    sweep(8.0, 2.0, +0.15);
    sweep(2.0, 8.0, -0.15);
  }
}

TEST(ValveHysteresis, ReversalWithinTheWidthMovesNothing) {
  ValveHysteresis<double> loop = loop_of(0.4);
  const double stuck_V = loop.follow(6.0);
  EXPECT_NEAR(stuck_V, 5.8, kPlay_V);
  for (const double u : {5.9, 5.7, 5.61, 5.99, 5.75})
    EXPECT_NEAR(loop.follow(u), stuck_V, kPlay_V) << "V at command " << u;
  EXPECT_NEAR(loop.follow(5.5), 5.7, kPlay_V);
}

TEST(ValveHysteresis, OnASpringTheFrictionTakesHoldOverTheSpoolsOwnWay) {
  // Dahl: m runs from 1 to -1 as 2 e^(-s/(d w/2)) - 1 over the way s of the spool, which is read off the loop itself
  constexpr double kHalf_V = 0.1;
  for (const double softness : {0.02, 0.5, 3.0}) {
    for (const double step_V : {0.01, 0.09, 0.7}) {
      ValveHysteresis<double> loop = swept_up(2.0 * kHalf_V, softness, 1.0, 1.0);
      const double turn_V = loop.follow(9.0);
      for (double way_V = step_V; way_V < 1.5; way_V += step_V) {
        const double command_V = 9.0 - way_V;
        const double x_V = loop.follow(command_V);
        const double friction = 2.0 * std::exp(-(turn_V - x_V) / (softness * kHalf_V)) - 1.0;
        ASSERT_NEAR((command_V - x_V) / kHalf_V, friction, 3e-4)
            << "back by " << way_V << " V in steps of " << step_V << ", softness " << softness;
      }
    }
  }
}

TEST(ValveHysteresis, WithoutASpringItTakesHoldOverTheWayOfTheCommandAsBoucAndWenSay) {
  // swept up far, m = 1, then back by y: m' = -1 - (2 b - 1) m over l = y/z until m = 0, then m' = -1 - m
  constexpr double kWidth_V = 0.2, kSoftness = 0.7;
  for (const double b : {0.5, 0.75, 1.0}) {
    const double yielding = 2.0 * b - 1.0;
    const auto friction = [&](double way_V) {
      const double way = way_V / ((kSoftness + 2.0 * b) * 0.5 * kWidth_V);
      const double free = yielding > 0.0 ? std::log1p(yielding) / yielding : 1.0;
      if (way > free) return std::exp(free - way) - 1.0;
      return yielding > 0.0 ? ((1.0 + yielding) * std::exp(-yielding * way) - 1.0) / yielding : 1.0 - way;
    };
    for (const double step_V : {0.01, 0.09, 0.8}) {
      ValveHysteresis<double> loop = swept_up(kWidth_V, kSoftness, 0.0, b);
      for (double way_V = step_V; way_V < 1.0; way_V += step_V) {
        ASSERT_NEAR(loop.follow(9.0 - way_V), 9.0 - way_V - 0.5 * kWidth_V * friction(way_V), 2e-5)
            << "V, back by " << way_V << " in steps of " << step_V << ", b " << b;
      }
    }
  }
}

TEST(ValveHysteresis, BetweenItFollowsItsEquationOnAnyCommand) {
  constexpr double kHalf_V = 0.1, kSoftness = 0.3, kFine_V = 1e-6;
  for (const double spring : {0.3, 0.8}) {
    for (const double b : {0.5, 0.8, 1.0}) {
      ValveHysteresis<double> loop = loop_of(2.0 * kHalf_V, kSoftness, spring, b);
      double m = 0.0, from_V = 5.0;
      for (const double command_V : {5.05, 5.4, 5.3, 5.36, 4.9, 5.01, 4.2, 7.0, 6.9}) {
        const double s = command_V > from_V ? 1.0 : -1.0;
        const auto slope = [&](double at) {
          const double loose = s * at > 0.0 ? 1.0 - s * at : 1.0 - (2.0 * b - 1.0) * s * at;
          return s * loose / (kSoftness + 2.0 * b * (1.0 - spring) + spring * loose) / kHalf_V;
        };
        const auto steps = static_cast<int>(std::lround(std::abs(command_V - from_V) / kFine_V));
        for (int i = 0; i < steps; ++i) {
          m += kFine_V * slope(m + 0.5 * kFine_V * slope(m));  // midpoint rule
        }
        from_V = command_V;
        ASSERT_NEAR(loop.follow(command_V), command_V - kHalf_V * m, 1e-4 * kHalf_V)
            << "V at " << command_V << " V, spring " << spring << ", b " << b;
      }
    }
  }
}

TEST(ValveHysteresis, AfterAReversalItFollowsWithTheShareThatItsSoftnessSays) {
  constexpr double kSoftness = 0.4, kWay_V = 1e-5;
  for (const double spring : {0.0, 0.5, 1.0}) {
    for (const double b : {0.5, 0.8, 1.0}) {
      ValveHysteresis<double> loop = swept_up(0.2, kSoftness, spring, b);
      const double turn_V = loop.follow(9.0);
      EXPECT_NEAR((turn_V - loop.follow(9.0 - kWay_V)) / kWay_V, kSoftness / (kSoftness + 2.0 * b), 2e-3)
          << "spring " << spring << ", b " << b;
    }
  }
}

TEST(ValveHysteresis, AtABoundOfItsFiguresASmallChangeIsFelt) {
  // what a fit differentiates by, beside a change a hundred times as large
  struct Bound {
    std::size_t figure;
    double at, inwards;
  };
  for (const Bound& bound :
       {Bound{1, 0.0, 1.0}, {2, 0.0, 1.0}, {2, 1.0, -1.0}, {3, 0.5, 1.0}, {3, 1.0, -1.0}}) {
    for (const double spring : {0.7, 1.0}) {
      double x[] = {0.2, 0.3, spring, 0.8};
      const auto place_V = [&](double more) {
        x[bound.figure] = bound.at + more * bound.inwards;
        ValveHysteresis<double> loop;
        loop.prepare(x, 5.0);
        loop.follow(9.0);
        return loop.follow(8.93);
      };
      const double at_V = place_V(0.0);
      const double small_V = (place_V(1e-5) - at_V) / 1e-5, large_V = (place_V(1e-3) - at_V) / 1e-3;
      EXPECT_GT(std::abs(large_V), 1e-4) << "V, figure " << bound.figure << " at " << bound.at;
      EXPECT_NEAR(small_V / large_V, 1.0, 0.1)
          << "figure " << bound.figure << " at " << bound.at << ", spring " << spring;
    }
  }
}

TEST(ValveHysteresis, LettingGoInProportionHoldsTheSpoolUntilTheFrictionIsGone) {
  // b = 1/2, d = 0: the friction falls as fast as the command, so nothing moves over half the width
  for (const double spring : {0.0, 0.5}) {
    ValveHysteresis<double> loop = loop_of(0.4, 0.0, spring, 0.5);
    const double end_V = loop.follow(9.0);
    for (const double u : {8.95, 8.9, 8.81}) EXPECT_NEAR(loop.follow(u), end_V, 2e-4) << "V at command " << u;
    EXPECT_LT(loop.follow(8.7), end_V - 0.005) << "spring " << spring;
  }
}

/// A loop of 0.2 V is as wide as the play's, and its spool never moves against the command.
void expect_passive_loop(ValveHysteresis<double> loop) {
  double before_V = loop.follow(5.0);
  for (int k = 1; k <= 800; ++k) {
    const double up = k <= 400 ? 1.0 : -1.0;
    const double u = 5.0 + 0.005 * (k <= 400 ? k : 800 - k);
    const double place_V = loop.follow(u);
    ASSERT_GE(up * (place_V - before_V), -kPlay_V) << "V, command " << u;
    if (k == 400 || k == 800) {
      EXPECT_NEAR(place_V, u - up * 0.1, 1e-4) << "V";
    }
    before_V = place_V;
  }
}

TEST(ValveHysteresis, RoundedLoopIsAsWideAsThePlayAndNeverMovesAgainstItsCommand) {
  for (const double b : {1.0, 0.8, 0.5}) {
    for (const double spring : {0.0, 0.6, 1.0}) {
      SCOPED_TRACE(testing::Message() << "b " << b << ", spring " << spring);
      expect_passive_loop(loop_of(0.2, 0.0, spring, b));
      expect_passive_loop(loop_of(0.2, 0.1, spring, b));
    }
  }
}

TEST(ValveHysteresis, WithoutWidthTheSpoolIsWhereItsCommandIs) {
  ValveHysteresis<double> loop = loop_of(0.0);
  for (const double u : {5.0, 7.3, 2.0, 2.0, 9.9}) EXPECT_EQ(loop.follow(u), u);
}

}  // namespace
}  // namespace plenum::host::effects
