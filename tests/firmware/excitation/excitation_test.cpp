#include "firmware/control/excitation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <vector>

#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

// A chamber of its own, in double and SI units: ideal nozzles (choked below a pressure ratio of 0.528, the
// ISO 6358 ellipse above), areas linear in the command with a leak, adiabatic, explicit Euler at a hundredth
// of a tick.
struct Chamber {
  double area_per_V_m2 = 1.5e-6;
  double volume_m3 = 100e-6;
  double volume_swing = 0.0;  // amplitude, of the volume
  double swing_Hz = 1.0;
  double null_V = 5.0;
  double supply_Pa = 620e3;
  double leak_m2 = 0.1e-6;

  double pressure_Pa = 101325.0;
  double time_s = 0.0;
  double lowest_kPa = std::numeric_limits<double>::infinity();
  double highest_kPa = 0.0;

  static double flow_kg_s(double area_m2, double up_Pa, double down_Pa) {
    if (up_Pa < down_Pa) return -flow_kg_s(area_m2, down_Pa, up_Pa);
    const double ratio = down_Pa / up_Pa, critical = 0.528;
    const double choked = 0.72 * 0.0404 * area_m2 * up_Pa / std::sqrt(293.0);
    if (ratio <= critical) return choked;
    const double x = (ratio - critical) / (1.0 - critical);
    return choked * std::sqrt(std::max(0.0, 1.0 - x * x));
  }

  // One tick at a command; the mean pressure over it [kPa].
  double tick_kPa(double command_V) {
    constexpr int kSteps = 100;
    const double h = 0.01 / kSteps;
    double sum_Pa = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double opening_V = command_V - null_V;
      const double inlet_m2 = leak_m2 + area_per_V_m2 * std::max(0.0, opening_V);
      const double outlet_m2 = leak_m2 + area_per_V_m2 * std::max(0.0, -opening_V);
      const double w = 2.0 * std::numbers::pi * swing_Hz;
      const double v = volume_m3 * (1.0 + volume_swing * std::sin(w * time_s));
      const double v_dot = volume_m3 * volume_swing * w * std::cos(w * time_s);
      const double flow =
          flow_kg_s(inlet_m2, supply_Pa, pressure_Pa) - flow_kg_s(outlet_m2, pressure_Pa, 101325.0);
      pressure_Pa += h * (1.4 / v) * (287.0 * 293.0 * flow - v_dot * pressure_Pa);
      time_s += h;
      sum_Pa += pressure_Pa;
      lowest_kPa = std::min(lowest_kPa, pressure_Pa / 1e3);
      highest_kPa = std::max(highest_kPa, pressure_Pa / 1e3);
    }
    return sum_Pa / kSteps / 1e3;
  }
};

// The fastest that the moving wall alone changes a pressure: kappa p max(v'/v), with max(v'/v) = w s / sqrt(1
// - s^2).
double wall_Pa_s(const Chamber& chamber, double pressure_Pa) {
  const double s = chamber.volume_swing;
  return 1.4 * pressure_Pa * 2.0 * std::numbers::pi * chamber.swing_Hz * s / std::sqrt(1.0 - s * s);
}

Excitation configured(const Excitation::Config& config) {
  Excitation excitation;
  excitation.configure(config);
  return excitation;
}

std::vector<Scalar> commands_at(Scalar pressure_kPa, std::uint32_t seed, int ticks) {
  Excitation excitation = configured({.seed = seed});
  std::vector<Scalar> commands_V;
  for (int tick = 0; tick < ticks; ++tick) commands_V.push_back(excitation.step(pressure_kPa));
  return commands_V;
}

// Runs 60 s and answers with the commands; the chamber keeps the extremes after its first second, in which
// the pressure comes up from ambient.
std::vector<Scalar> run(Chamber& chamber, const Excitation::Config& config) {
  Excitation excitation = configured(config);
  std::vector<Scalar> commands_V;
  double pressure_kPa = chamber.pressure_Pa / 1e3;
  for (int tick = 0; tick < 6000; ++tick) {
    if (tick == 100) {
      chamber.lowest_kPa = std::numeric_limits<double>::infinity();
      chamber.highest_kPa = 0.0;
    }
    commands_V.push_back(excitation.step(static_cast<Scalar>(pressure_kPa)));
    pressure_kPa = chamber.tick_kPa(static_cast<double>(commands_V.back()));
  }
  return commands_V;
}

TEST(Excitation, StaysInsideTheCommandRangeAtAnyPressure) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::array<Scalar, 9> pressures_kPa = {
      -kInfinity, -1e30F,    0.0F,
      130.0F,     350.0F,    600.0F,
      1e30F,      kInfinity, std::numeric_limits<float>::quiet_NaN()};
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    Excitation excitation =
        configured({.seed = seed, .command_low_V = 3.5F, .command_high_V = 6.0F, .null_V = 4.9F});
    for (int tick = 0; tick < 5000; ++tick) {
      const Scalar pressure_kPa =
          pressures_kPa[static_cast<std::size_t>(tick * 7 + tick / 50) % pressures_kPa.size()];
      const Scalar command_V = excitation.step(pressure_kPa);
      ASSERT_GE(command_V, 3.5F) << "seed " << seed << ", tick " << tick << ", " << pressure_kPa << " kPa";
      ASSERT_LE(command_V, 6.0F) << "seed " << seed << ", tick " << tick << ", " << pressure_kPa << " kPa";
      if (!numeric::is_finite(pressure_kPa)) {
        ASSERT_EQ(command_V, 4.9F);
      }
    }
  }
}

TEST(Excitation, RepeatsItselfFromItsSeedAndDiffersBetweenSeeds) {
  std::set<std::vector<Scalar>> different;
  for (const std::uint32_t seed : {0U, 1U, 2U, 3U, 0x61C88647U, 0xFFFFFFFFU}) {
    EXPECT_EQ(commands_at(350.0F, seed, 500), commands_at(350.0F, seed, 500)) << "seed " << seed;
    different.insert(commands_at(350.0F, seed, 500));
  }
  EXPECT_EQ(different.size(), 6U);
}

TEST(Excitation, StartsAfreshWhenConfiguredAgain) {
  Excitation used = configured({.seed = 4});
  for (int tick = 0; tick < 333; ++tick) used.step(static_cast<Scalar>(tick * 3));
  used.configure({.seed = 9});
  Excitation fresh = configured({.seed = 9});
  for (int tick = 0; tick < 500; ++tick) ASSERT_EQ(used.step(350.0F), fresh.step(350.0F)) << "tick " << tick;
}

// 100,000 ticks in the middle of the pressure range, where the guard leaves every command alone. By the
// segments' shares and mean lengths (levels 1/2 x 21, near null 1/4 x 22.5, ramps 1/8 x 85, strokes 1/8 x 7
// ticks) levels alone have 38 % of the time, 1.9 % a bin of 0.2 V, to which ramps add; 20 % are spent near
// the null.
TEST(Excitation, CoversTheCommandRangeAndDwellsNearTheNull) {
  const std::vector<Scalar> commands_V = commands_at(365.0F, 77, 100000);
  std::array<int, 20> bins{};
  for (const Scalar command_V : commands_V) {
    ++bins[static_cast<std::size_t>(std::min(19.0, real(command_V - 3.0F) / 0.2))];
  }
  for (std::size_t i = 0; i < bins.size(); ++i) {
    EXPECT_GE(bins[i], 1900) << "commands from " << 3.0 + 0.2 * static_cast<double>(i) << " V";
  }
  EXPECT_GE(bins[9] + bins[10], 100000 / 5) << "within 0.2 V of the null";
  EXPECT_EQ(*std::min_element(commands_V.begin(), commands_V.end()), 3.0F);
  EXPECT_EQ(*std::max_element(commands_V.begin(), commands_V.end()), 7.0F);
}

TEST(Excitation, HoldsLevelsForTwoTicksToFourHundredMilliseconds) {
  const std::vector<Scalar> commands_V = commands_at(365.0F, 5, 20000);
  std::size_t ramped = 0, longest = 0, held = 1;
  for (std::size_t i = 1; i < commands_V.size(); ++i) {
    if (commands_V[i] == commands_V[i - 1]) {
      ++held;
    } else {
      ramped += held == 1 ? 1U : 0U;
      longest = std::max(longest, held);
      held = 1;
    }
  }
  EXPECT_LE(longest, 41U) << "ticks: the longest hold and a ramp's last value";
  EXPECT_GE(longest, 38U);
  EXPECT_GE(ramped, commands_V.size() / 10) << "ticks of ramps";
}

TEST(Excitation, ForcesExhaustAboveAndSupplyBelowTheLimitsUntilTheHysteresisIsPassed) {
  const Excitation::Config config{.seed = 3};
  Excitation excitation = configured(config);
  excitation.step(599.0F);
  for (int tick = 0; tick < 100; ++tick) {
    EXPECT_LE(excitation.step(tick < 50 ? 605.0F : 575.0F), 4.5F) << "tick " << tick;
  }
  excitation.configure(config);
  for (int tick = 0; tick < 100; ++tick) {
    EXPECT_GE(excitation.step(tick < 50 ? 120.0F : 155.0F), 5.5F) << "tick " << tick;
  }
  bool released = false;
  for (int tick = 0; tick < 100; ++tick) released = released || excitation.step(165.0F) < 5.5F;
  EXPECT_TRUE(released);
}

// What takes the pressure past a limit before the guard can answer: the flow through the valve's own null
// error and leak, and the moving wall, for two ticks. The tick that crosses the limit may still have its mean
// below it, so the next one is not yet forced; its mean shows it.
double granted_kPa(const Chamber& chamber, double limit_Pa) {
  const double stray_m2 = chamber.leak_m2 + chamber.area_per_V_m2 * std::abs(5.0 - chamber.null_V);
  const double least_m3 = chamber.volume_m3 * (1.0 - chamber.volume_swing);
  const double stray_Pa_s =
      1.4 * 287.0 * 293.0 * Chamber::flow_kg_s(stray_m2, chamber.supply_Pa, limit_Pa) / least_m3;
  return 0.02 * (stray_Pa_s + wall_Pa_s(chamber, limit_Pa)) / 1e3;
}

TEST(Excitation, KeepsAChamberInsideItsPressureLimitsWhereTheValveIsStrongerThanTheWall) {
  int judged = 0;
  for (const double area_per_V_m2 : {0.8e-6, 1.5e-6, 2.2e-6}) {
    for (const double volume_m3 : {40e-6, 100e-6, 300e-6}) {
      for (const double swing : {0.0, 0.1, 0.2}) {
        for (const double null_V : {4.85, 5.15}) {
          Chamber chamber{.area_per_V_m2 = area_per_V_m2,
                          .volume_m3 = volume_m3,
                          .volume_swing = swing,
                          .null_V = null_V};
          const double open_Pa_s = 1.4 * 287.0 * 293.0 / volume_m3 *
                                   std::min(Chamber::flow_kg_s(1.85 * area_per_V_m2, 450e3, 101325.0),
                                            Chamber::flow_kg_s(1.85 * area_per_V_m2, 130e3, 101325.0));
          if (wall_Pa_s(chamber, 450e3) > open_Pa_s) continue;
          ++judged;
          run(chamber, {.seed = 11, .pressure_high_kPa = 450.0F});
          EXPECT_LE(chamber.highest_kPa, 450.0 + granted_kPa(chamber, 450e3))
              << area_per_V_m2 << " m2/V, " << volume_m3 << " m3, swing " << swing << ", null " << null_V
              << " V";
          EXPECT_GE(chamber.lowest_kPa, 130.0 - granted_kPa(chamber, 130e3))
              << area_per_V_m2 << " m2/V, " << volume_m3 << " m3, swing " << swing << ", null " << null_V
              << " V";
          EXPECT_GE(chamber.highest_kPa - chamber.lowest_kPa, 0.6 * (450.0 - 130.0))
              << "the range must be used";
        }
      }
    }
  }
  EXPECT_GE(judged, 20);
}

// The fastest chamber goes from limit to limit in two or three ticks, so that its mean over a tick hides
// reversals.
TEST(Excitation, KeepsTheFastestChamberInsideItsPressureLimitsFromAnySeed) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    for (const double null_V : {4.85, 5.15}) {
      Chamber chamber{.area_per_V_m2 = 2.2e-6, .volume_m3 = 40e-6, .null_V = null_V};
      run(chamber, {.seed = seed, .pressure_high_kPa = 450.0F});
      EXPECT_LE(chamber.highest_kPa, 450.0 + granted_kPa(chamber, 450e3))
          << "seed " << seed << ", null " << null_V;
      EXPECT_GE(chamber.lowest_kPa, 130.0 - granted_kPa(chamber, 130e3))
          << "seed " << seed << ", null " << null_V;
    }
  }
}

// 5 mL behind the same valve fill and empty within a tick: what a tick does is known after it has been done.
TEST(Excitation, DoesNotThrowAChamberOfMillilitresFromLimitToLimit) {
  constexpr double kLimit_kPa = 400.0;
  for (const double leak_m2 : {0.02e-6, 0.1e-6}) {
    int ticks = 0, beyond = 0;
    double highest_kPa = 0.0;
    for (std::uint32_t seed = 1; seed <= 2; ++seed) {
      Chamber chamber{.volume_m3 = 5e-6, .leak_m2 = leak_m2};
      Excitation excitation =
          configured({.seed = seed, .pressure_high_kPa = static_cast<Scalar>(kLimit_kPa)});
      double mean_kPa = chamber.pressure_Pa / 1e3;
      for (int tick = 0; tick < 3000; ++tick) {
        mean_kPa = chamber.tick_kPa(static_cast<double>(excitation.step(static_cast<Scalar>(mean_kPa))));
        if (tick < 100) continue;
        ++ticks;
        beyond += mean_kPa > kLimit_kPa ? 1 : 0;
        highest_kPa = std::max(highest_kPa, mean_kPa);
      }
    }
    EXPECT_LT(beyond, ticks / 200) << "a third, as long as the guard opened the valve fully";
    EXPECT_LT(highest_kPa, 1.15 * kLimit_kPa) << "1.4 times";
  }
}

// 300 mL swinging by a fifth at 1 Hz behind a weak valve: the wall wins, but the valve must be fully open
// against it.
TEST(Excitation, OpensTheValveFullyAgainstAPressureBeyondALimit) {
  Chamber chamber{.area_per_V_m2 = 0.8e-6, .volume_m3 = 300e-6, .volume_swing = 0.2};
  Excitation excitation = configured({.seed = 2, .pressure_high_kPa = 450.0F});
  double pressure_kPa = chamber.pressure_Pa / 1e3;
  int beyond = 0;
  for (int tick = 0; tick < 6000; ++tick) {
    const Scalar command_V = excitation.step(static_cast<Scalar>(pressure_kPa));
    if (pressure_kPa > 450.0) {
      EXPECT_EQ(command_V, 3.0F) << "tick " << tick;
      ++beyond;
    }
    pressure_kPa = chamber.tick_kPa(static_cast<double>(command_V));
  }
  EXPECT_GT(beyond, 100);
}

TEST(RestrictTo, NeverAllowsMoreThanTheInstaller) {
  const config::ChamberSettings settings;
  Excitation::Config asked{
      .command_low_V = 0.0F, .command_high_V = 10.0F, .pressure_low_kPa = 0.0F, .pressure_high_kPa = 5000.0F};
  Excitation::Config got = restrict_to(asked, settings).value();
  EXPECT_EQ(got.command_low_V, settings.command_low_V);
  EXPECT_EQ(got.command_high_V, settings.command_high_V);
  EXPECT_EQ(got.pressure_low_kPa, settings.pressure_low_kPa);
  EXPECT_EQ(got.pressure_high_kPa, settings.pressure_high_kPa);
  EXPECT_EQ(got.null_V, settings.null_V);

  asked = {.seed = 12,
           .command_low_V = 4.0F,
           .command_high_V = 6.0F,
           .pressure_low_kPa = 200.0F,
           .pressure_high_kPa = 400.0F};
  got = restrict_to(asked, settings).value();
  EXPECT_EQ(got.seed, 12U);
  EXPECT_EQ(got.command_low_V, 4.0F);
  EXPECT_EQ(got.command_high_V, 6.0F);
  EXPECT_EQ(got.pressure_low_kPa, 200.0F);
  EXPECT_EQ(got.pressure_high_kPa, 400.0F);
}

TEST(RestrictTo, LeavesNothingOfARangeThatMakesNoSense) {
  const config::ChamberSettings settings;
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();  // 0 in fixed point
  for (const auto& [low_V, high_V] :
       {std::pair{6.0F, 4.0F}, {5.5F, 7.0F}, {3.0F, 5.0F}, {4.5F, 4.99F}, {5.05F, 5.6F}, {3.0F, nan}}) {
    EXPECT_FALSE(restrict_to({.command_low_V = low_V, .command_high_V = high_V}, settings))
        << low_V << ".." << high_V << " V";
  }
  for (const auto& [low_kPa, high_kPa] : {std::pair{500.0F, 300.0F},
                                          {300.0F, 300.0F},
                                          {1.0F, 4.0F},
                                          {0.0F, settings.pressure_low_kPa},
                                          {settings.pressure_high_kPa, 2000.0F},
                                          {100.0F, nan}}) {
    EXPECT_FALSE(restrict_to({.pressure_low_kPa = low_kPa, .pressure_high_kPa = high_kPa}, settings))
        << low_kPa << ".." << high_kPa << " kPa";
  }
}

}  // namespace
}  // namespace plenum::control
