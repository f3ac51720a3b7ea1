// spool_lag, dead_time, valve_hysteresis, null_drift: what they make of the command, against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <complex>
#include <numbers>
#include <numeric>

#include "host-sim/plant/chamber.hpp"
#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

// ---- spool_lag

constexpr double kNull_V = 5.0;

/// Position of a second-order lag a time after its command has stepped from 0 to 1.
double step_response(double time_s, double frequency_Hz, double damping) {
  const double wt = 2.0 * std::numbers::pi * frequency_Hz * time_s;
  if (damping == 1.0) return 1.0 - (1.0 + wt) * std::exp(-wt);
  const std::complex<double> gap = std::sqrt(std::complex<double>(damping * damping - 1.0));
  const std::complex<double> a = -damping + gap;
  const std::complex<double> b = -damping - gap;
  return 1.0 - ((a * std::exp(b * wt) - b * std::exp(a * wt)) / (a - b)).real();
}

/// Its mean from `from_s` over `span_s`, by Simpson's rule in 200 pieces.
double mean_step_response(double from_s, double span_s, double frequency_Hz, double damping) {
  constexpr int kPieces = 200;
  double sum = 0.0;
  for (int i = 0; i <= kPieces; ++i) {
    const double weight = i == 0 || i == kPieces ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum += weight * step_response(from_s + span_s * i / kPieces, frequency_Hz, damping);
  }
  return sum / (3.0 * kPieces);
}

SpoolLag<double> spool_of(double frequency_Hz, double damping, double step_s) {
  const double x[] = {1.0 / frequency_Hz, damping, 0.0, 0.0, 0.0, 0.0};
  SpoolLag<double> spool;
  spool.prepare(x, step_s, 0.0, kNull_V);
  return spool;
}

TEST(SpoolLag, StepResponseMatchesTheClosedFormAtAnyStep) {
  for (const double damping : {0.4, 0.8, 1.0, 1.7, 10.0}) {
    for (const double step_s : {0.0001, 0.0025, 0.01, 0.02}) {
      SpoolLag<double> spool = spool_of(12.0, damping, step_s);
      // where the poles meet they are moved apart by 1e-4
      const double within = damping == 1.0 ? 1e-4 : 1e-9;
      for (int k = 0; k * step_s < 0.2; ++k) {
        ASSERT_NEAR(spool.follow(1.0), mean_step_response(k * step_s, step_s, 12.0, damping), within)
            << "V, damping " << damping << " step " << step_s << " s, number " << k;
      }
    }
  }
}

TEST(SpoolLag, InfinitelyFastSpoolIsWhereItsCommandIs) {
  SpoolLag<double> spool = spool_of(kInfinity, 0.8, 0.0025);
  for (const double u : {5.0, 7.3, 2.0, 2.0, 9.9}) EXPECT_EQ(spool.follow(u), u);
}

TEST(SpoolLag, SpoolFasterThanTheStepIsLateByTwiceItsDampingOverItsFrequency) {
  for (const double frequency_Hz : {400.0, 2000.0, 1e5}) {
    SpoolLag<double> spool = spool_of(frequency_Hz, 0.6, 0.01);
    const double late_s = 2.0 * 0.6 / (2.0 * std::numbers::pi * frequency_Hz);
    double area_s = 0.0;
    for (int k = 0; k < 10; ++k) area_s += 0.01 * (1.0 - spool.follow(1.0));
    EXPECT_NEAR(area_s / late_s, 1.0, 1e-6) << frequency_Hz << " Hz";
  }
}

TEST(SpoolLag, SpoolOfLimitedSpeedFollowsARampAsLateAsTheForceForItsSpeedTakes) {
  // x' = r asks for v = r/sqrt(1 - (r/S)^2), and v for c - x = 2 zeta v/w
  const double step_s = 1e-4, damping = 0.7, slew_V_s = 40.0, frequency_Hz = 20.0;
  const double omega_1_s = 2.0 * std::numbers::pi * frequency_Hz;
  for (const double rate_V_s : {5.0, 20.0, 36.0}) {
    const double x[] = {1.0 / frequency_Hz, damping, 1.0 / (slew_V_s * slew_V_s), 0.0, 0.0, 0.0};
    SpoolLag<double> spool;
    spool.prepare(x, step_s, 0.0, kNull_V);
    double late_V = 0.0;
    for (int k = 0; k < 10000; ++k) {
      const double command_V = rate_V_s * step_s * (k + 0.5);
      late_V = command_V - spool.follow(command_V);
    }
    const double share = rate_V_s / slew_V_s;
    const double expected_V = 2.0 * damping / omega_1_s * rate_V_s / std::sqrt(1.0 - share * share);
    EXPECT_NEAR(late_V / expected_V, 1.0, 1e-3) << rate_V_s << " V/s";
  }
}

TEST(SpoolLag, NoSpoolIsFasterThanItsSlew) {
  for (const double frequency_Hz : {10.0, 100.0, 1e4, kInfinity}) {
    const double slew_V_s = 30.0, step_s = 0.001;
    const double x[] = {1.0 / frequency_Hz, 0.5, 1.0 / (slew_V_s * slew_V_s), 0.0, 0.0, 0.0};
    SpoolLag<double> spool;
    spool.prepare(x, step_s, 0.0, kNull_V);
    for (int k = 0; k < 100; ++k) {
      ASSERT_LE(spool.follow(5.0), slew_V_s * step_s * (k + 1))
          << "V after step " << k << ", " << frequency_Hz << " Hz";
    }
    for (int k = 0; k < 900; ++k) spool.follow(5.0);
    EXPECT_NEAR(spool.follow(5.0), 5.0, 1e-3) << "V, " << frequency_Hz << " Hz: it arrives";
  }
}

TEST(SpoolLag, CoilBeforeAFastSpoolIsAFirstOrderLag) {
  const double step_s = 0.002, coil_s = 0.006;
  const double x[] = {0.0, 0.8, 0.0, coil_s, 0.0, 0.0};
  SpoolLag<double> spool;
  spool.prepare(x, step_s, 0.0, kNull_V);
  for (int k = 0; k < 30; ++k) {
    const double begin = std::exp(-k * step_s / coil_s), end = std::exp(-(k + 1) * step_s / coil_s);
    ASSERT_NEAR(spool.follow(1.0), 1.0 - coil_s / step_s * (begin - end), 1e-12) << "V, step " << k;
  }
}

TEST(SpoolLag, CoilThatFallsFasterThanItRisesIsADifferentLagEachWay) {
  const double step_s = 0.002, coil_s = 0.006, rise = 0.5;
  const double x[] = {0.0, 0.8, 0.0, coil_s, rise, 0.0};
  SpoolLag<double> spool;
  spool.prepare(x, step_s, 0.0, kNull_V);
  for (int k = 0; k < 400; ++k) {
    const double tau_s = coil_s * (1.0 + rise), begin = std::exp(-k * step_s / tau_s);
    ASSERT_NEAR(spool.follow(1.0), 1.0 - tau_s / step_s * begin * (1.0 - std::exp(-step_s / tau_s)), 1e-12)
        << "V up, step " << k;
  }
  for (int k = 0; k < 20; ++k) {
    const double tau_s = coil_s * (1.0 - rise), begin = std::exp(-k * step_s / tau_s);
    ASSERT_NEAR(spool.follow(0.0), tau_s / step_s * begin * (1.0 - std::exp(-step_s / tau_s)), 1e-12)
        << "V down, step " << k;
  }
}

TEST(SpoolLag, CoilThatComesBackMoreSlowlyThanItLeavesIsADifferentLagOnEitherSideOfTheNull) {
  const double step_s = 0.002, coil_s = 0.006, back = 0.3;
  const double x[] = {0.0, 0.8, 0.0, coil_s, 0.0, back};
  for (const double side : {1.0, -1.0}) {
    SpoolLag<double> spool;
    spool.prepare(x, step_s, kNull_V, kNull_V);
    const auto mean_of = [&](double tau_s, int k) {
      return tau_s / step_s * std::exp(-k * step_s / tau_s) * (1.0 - std::exp(-step_s / tau_s));
    };
    for (int k = 0; k < 400; ++k) {
      ASSERT_NEAR(side * (spool.follow(kNull_V + side) - kNull_V), 1.0 - mean_of(coil_s * (1.0 - back), k),
                  1e-12)
          << "V away, step " << k << ", side " << side;
    }
    for (int k = 0; k < 20; ++k) {
      ASSERT_NEAR(side * (spool.follow(kNull_V) - kNull_V), mean_of(coil_s * (1.0 + back), k), 1e-12)
          << "V back, step " << k << ", side " << side;
    }
  }
}

TEST(SpoolLag, ChamberAgreesWithThePlantThatHasTheSameSpool) {
  const std::vector<double> command_V = jumping_command_V(1500);
  for (const double frequency_Hz : {10.0, 65.0, 125.0}) {
    plant::ChamberConfig config;
    config.initial_pressure_Pa = 3e5;
    config.initial_command_V = command_V.front();
    config.spool = plant::SpoolConfig{.natural_frequency_Hz = frequency_Hz, .damping_ratio = 0.7};
    config.tolerance_Pa = 0.02;
    plant::ChamberPlant plant(plant::ThinPlateValve({}), config, swinging_volume());
    std::vector<double> truth_Pa{3e5};
    for (std::size_t k = 0; k + 1 < command_V.size(); ++k) {
      truth_Pa.push_back(plant.advance(command_V[k], kTick_s).mean_Pa);
    }
    const Figures figures = with(nominal(), kIdSpoolLag, {frequency_Hz, 0.7});
    const auto error_Pa = [&](int steps) {
      return rms_difference(
          run(only(kIdSpoolLag), figures, drive_of(command_V, swinging_volume(), steps), 3e5), truth_Pa);
    };
    EXPECT_LT(error_Pa(4), 50.0) << "Pa RMS at " << frequency_Hz << " Hz";
    EXPECT_LT(error_Pa(16), 4.0) << "Pa RMS at " << frequency_Hz << " Hz";
  }
}

// ---- dead_time

DeadTime<double> dead_time_of(double ticks, double rise = 0.0) {
  const double x[] = {ticks * kTick_s, rise};
  DeadTime<double> dead_time;
  dead_time.prepare(x, kTick_s, 5.0);
  return dead_time;
}

TEST(DeadTime, OfWholeTicksIsTheCommandOfThatManyTicksBefore) {
  for (int late = 0; late <= 8; ++late) {
    DeadTime<double> dead_time = dead_time_of(late);
    const std::vector<double> command_V = jumping_command_V(200);
    for (int k = 0; k < 200; ++k) {
      dead_time.hold(command_V[static_cast<std::size_t>(k)]);
      const double expected_V = k < late ? 5.0 : command_V[static_cast<std::size_t>(k - late)];
      for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(dead_time.during(0.25 * i, 0.25 * (i + 1)).mean(), expected_V, 1e-13)
            << "V, tick " << k << " late " << late;
      }
    }
  }
}

TEST(DeadTime, FractionOfATickSharesOutTheStepInWhichItEnds) {
  DeadTime<double> dead_time = dead_time_of(2.3);
  for (const double u : {1.0, 2.0, 4.0, 8.0}) dead_time.hold(u);
  EXPECT_EQ(dead_time.during(0.0, 0.25).mean(), 1.0) << "V: the delay ends at 0.3 of the tick";
  const auto held = dead_time.during(0.25, 0.5);
  EXPECT_EQ(held.first, 1.0);
  EXPECT_EQ(held.second, 2.0);
  EXPECT_NEAR(held.share, 0.2, 1e-12);
  EXPECT_EQ(dead_time.during(0.5, 0.75).mean(), 2.0);
  EXPECT_NEAR(dead_time.during(0.0, 1.0).mean(), 0.3 * 1.0 + 0.7 * 2.0, 1e-12) << "V: interpolated";
}

TEST(DeadTime, BeyondWhatIsRememberedItStaysAtTheLongestDelay) {
  DeadTime<double> dead_time = dead_time_of(500.0);
  for (int k = 0; k < 100; ++k) dead_time.hold(static_cast<double>(k));
  EXPECT_EQ(dead_time.during(0.0, 1.0).mean(), 99.0 - 31.0);
}

/// x in each thousandth of each tick.
std::vector<double> traced_V(DeadTime<double> dead_time, const std::vector<double>& command_V) {
  constexpr int kParts = 1000;
  std::vector<double> traced;
  for (const double u : command_V) {
    dead_time.hold(u);
    for (int i = 0; i < kParts; ++i) {
      traced.push_back(dead_time.during(i / double{kParts}, (i + 1) / double{kParts}).mean());
    }
  }
  return traced;
}

struct Edges {
  double rise_tick, fall_tick;
};
/// Of a command that rises over 6.5 V and falls again.
Edges edges_of(const std::vector<double>& x) {
  const auto rise = std::find_if(x.begin(), x.end(), [](double u) { return u > 6.5; });
  const auto fall = std::find_if(rise, x.end(), [](double u) { return u < 6.5; });
  return {static_cast<double>(rise - x.begin()) / 1000.0, static_cast<double>(fall - x.begin()) / 1000.0};
}

TEST(DeadTime, ThatIsUnevenLetsARiseActLaterThanAFall) {
  std::vector<double> command_V(12, 5.0);
  std::fill(command_V.begin() + 2, command_V.begin() + 7, 8.0);
  for (const double a : {0.3, -0.3}) {
    const Edges x = edges_of(traced_V(dead_time_of(2.0, a), command_V));
    EXPECT_NEAR(x.rise_tick, 2.0 + 2.0 * (1.0 + a), 2e-3) << "tick, a " << a;
    EXPECT_NEAR(x.fall_tick, 7.0 + 2.0 * (1.0 - a), 2e-3) << "tick, a " << a;
  }
}

TEST(DeadTime, ThatIsUnevenKeepsItsRatioBeyondWhatIsRemembered) {
  std::vector<double> command_V(100, 5.0);
  std::fill(command_V.begin() + 10, command_V.begin() + 60, 8.0);
  const Edges x = edges_of(traced_V(dead_time_of(50.0, 0.6), command_V));
  EXPECT_NEAR(x.rise_tick, 10.0 + 31.0, 2e-3) << "tick: the longest that is known";
  EXPECT_NEAR(x.fall_tick, 60.0 + 31.0 * 0.4 / 1.6, 2e-3) << "tick";
}

TEST(DeadTime, ThatIsUnevenDoesNotSeeWhatIsTakenBackBeforeItActs) {
  std::vector<double> command_V(12, 5.0);
  command_V[3] = 8.0;  // a tick, where a rise is 1.2 ticks later than a fall
  EXPECT_THAT(traced_V(dead_time_of(2.0, 0.3), command_V), testing::Each(5.0));
  const std::vector<double> longer = traced_V(dead_time_of(2.0, -0.3), command_V);
  EXPECT_NEAR(std::accumulate(longer.begin(), longer.end(), 0.0) / 1000.0, 12 * 5.0 + 3.0 * 2.2, 1e-2)
      << "V tick";
}

TEST(DeadTime, ThatIsUnevenMirrorsWithItsCommandAndIsPlainAtZero) {
  const std::vector<double> command_V = jumping_command_V(60);
  std::vector<double> mirrored_V;
  for (const double u : command_V) mirrored_V.push_back(10.0 - u);
  const std::vector<double> one = traced_V(dead_time_of(1.7, 0.4), command_V);
  const std::vector<double> other = traced_V(dead_time_of(1.7, -0.4), mirrored_V);
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_NEAR(one[i], 10.0 - other[i], 1e-12);
  const std::vector<double> plain = traced_V(dead_time_of(1.7), command_V);
  const std::vector<double> nearly = traced_V(dead_time_of(1.7, 1e-9), command_V);
  for (std::size_t i = 0; i < plain.size(); ++i) ASSERT_NEAR(plain[i], nearly[i], 1e-4);
}

TEST(DeadTime, ThatIsUnevenHasOverAStepTheMeanOfItsParts) {
  DeadTime<double> dead_time = dead_time_of(2.3, 0.25);
  DeadTime<double> finely = dead_time;
  const std::vector<double> command_V = jumping_command_V(200);
  for (const double u : command_V) {
    dead_time.hold(u);
    finely.hold(u);
    for (int i = 0; i < 4; ++i) {
      double sum = 0.0;
      for (int k = 0; k < 100; ++k) {
        sum += finely.during(0.25 * i + 0.0025 * k, 0.25 * i + 0.0025 * (k + 1)).mean() / 100.0;
      }
      ASSERT_NEAR(dead_time.during(0.25 * i, 0.25 * (i + 1)).mean(), sum, 1e-9) << "V";
    }
  }
}

TEST(DeadTime, ChamberAgreesWithThePlantThatIsFedLate) {
  const std::vector<double> command_V = jumping_command_V(1500);
  for (const double delay_s : {0.0005, 0.002, 0.0063, 0.01}) {
    plant::ChamberConfig config;
    config.initial_pressure_Pa = 3e5;
    config.initial_command_V = command_V.front();
    config.tolerance_Pa = 0.02;
    plant::ChamberPlant plant(plant::ThinPlateValve({}), config, swinging_volume());
    std::vector<double> truth_Pa{3e5};
    for (std::size_t k = 0; k + 1 < command_V.size(); ++k) {
      double area = delay_s * plant.advance(command_V[k == 0 ? 0 : k - 1], delay_s).mean_Pa;
      const double rest_s = kTick_s - delay_s;
      if (rest_s > 1e-12) area += rest_s * plant.advance(command_V[k], rest_s).mean_Pa;
      truth_Pa.push_back(area / kTick_s);
    }
    const Figures figures = with(nominal(), kIdDeadTime, {delay_s});
    const auto error_Pa = [&](int steps) {
      return rms_difference(
          run(only(kIdDeadTime), figures, drive_of(command_V, swinging_volume(), steps), 3e5), truth_Pa);
    };
    EXPECT_LT(error_Pa(4), 40.0) << "Pa RMS, delay " << delay_s << " s";
    EXPECT_LT(error_Pa(16), 4.0) << "Pa RMS, delay " << delay_s << " s";
  }
}

// ---- valve_hysteresis

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

// ---- null_drift

/// The drift at whole seconds, 0 to 80, of these coefficients of its spline.
std::vector<double> wander_V(const std::array<double, kNullKnots>& coefficients_V) {
  std::array<double, 2 + kNullKnots> x{};
  std::copy(coefficients_V.begin(), coefficients_V.end(), x.begin() + 2);
  NullDrift<double> drift;
  drift.prepare(x.data(), kTick_s);
  std::vector<double> at_second_V;
  for (int tick = 0; tick <= 8000; ++tick) {
    if (tick % 100 == 0) at_second_V.push_back(5.0 - drift.at(5.0));
    drift.end_tick();
  }
  return at_second_V;
}

TEST(NullDrift, EachCoefficientOfItsSplineIsACubicBasisFunctionThreeSecondsAKnot) {
  for (std::size_t k = 1; k < kNullKnots; ++k) {
    std::array<double, kNullKnots> coefficients_V{};
    coefficients_V[k - 1] = 0.3;
    const std::vector<double> drift_V = wander_V(coefficients_V);
    for (std::size_t second = 0; second <= 60; ++second) {
      // (2 - |x|)^3/6 - 4 (1 - |x|)^3/6 for |x| < 2, each power where its base is positive
      const double x = std::abs(static_cast<double>(second) / 3.0 - static_cast<double>(k));
      const double expected =
          0.3 * (std::pow(std::max(2.0 - x, 0.0), 3) - 4.0 * std::pow(std::max(1.0 - x, 0.0), 3)) / 6.0;
      EXPECT_NEAR(drift_V[second], expected, 1e-9) << "V, coefficient " << k << " at " << second << " s";
    }
  }
}

TEST(NullDrift, ItsSplineIsStraightWhereItsCoefficientsAreAndStandsAfterTheLast) {
  std::array<double, kNullKnots> coefficients_V{};
  for (std::size_t k = 0; k < kNullKnots; ++k) coefficients_V[k] = 0.01 * static_cast<double>(k + 1);
  const std::vector<double> drift_V = wander_V(coefficients_V);
  EXPECT_NEAR(drift_V.front(), 0.01 / 6.0, 1e-12) << "V";
  for (std::size_t second = 3; second <= 54; ++second) {
    EXPECT_NEAR(drift_V[second], 0.01 * static_cast<double>(second) / 3.0, 1e-9) << "V at " << second << " s";
  }
  EXPECT_NEAR(drift_V[60], 0.01 * (19.0 + 5.0 * 20.0) / 6.0, 1e-12) << "V";
  for (std::size_t second = 63; second <= 80; ++second) {
    EXPECT_NEAR(drift_V[second], coefficients_V.back(), 1e-12) << "V at " << second << " s";
  }
}

TEST(NullDrift, FollowsItsExponentialAndReachesItsFigureAtAMinute) {
  for (const double tau_s : {2.0, 25.0, 1e6, kInfinity}) {
    const std::array<double, 2 + kNullKnots> x{-0.7, 1.0 / tau_s};
    NullDrift<double> drift;
    drift.prepare(x.data(), kTick_s);
    for (int k = 0; k <= 6000; ++k) {
      const double t = k * kTick_s;
      const double share = std::isinf(tau_s) ? t / 60.0 : std::expm1(-t / tau_s) / std::expm1(-60.0 / tau_s);
      ASSERT_NEAR(drift.at(5.0), 5.0 + 0.7 * share, 1e-10) << "V at " << t << " s, tau " << tau_s << " s";
      drift.end_tick();
    }
  }
}

TEST(NullDrift, ShiftsBothPortsByTheSameCommand) {
  // after a minute of ramp the flows are those of a command lower by the drift
  const Figures drifting = with(nominal(), kIdNullDrift, {0.2, kInfinity});
  for (const double command_V : {6.0, 4.0}) {
    EXPECT_NEAR(flow_kg_s(only(kIdNullDrift), drifting, command_V, 3e5, {}, 6001) /
                    flow_kg_s(0, nominal(), command_V - 0.2, 3e5, {}, 6001),
                1.0, 1e-5)
        << "at command " << command_V << " V";
  }
}

}  // namespace
}  // namespace plenum::host::effects
