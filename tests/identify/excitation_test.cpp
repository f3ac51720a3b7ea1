#include "host-sim/identify/excitation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "tests/identify/chamber_of_record.hpp"

namespace plenum::host::identify {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

std::string refusal(const std::vector<trace::Log>& logs) {
  try {
    require_excitation(lay_out(logs));
  } catch (const CannotIdentify& error) {
    return error.what();
  }
  return "accepted";
}

/// Commands from 3 to 7 V, drawn anew every `hold` ticks, and the pressure [kPa] that `next` makes of the last one and the command,
/// read with white noise.
trace::Log log_of(unsigned seed, std::size_t rows, int hold, double noise_kPa,
                  const std::function<double(double p_kPa, double u_V)>& next, double p_kPa = 300.0) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> command(3.0, 7.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  trace::Log log;
  log.period_s = log.pressure_average_s = 0.01;
  double u_V = 5.0;
  for (std::size_t k = 0; k < rows; ++k) {
    if (k % static_cast<std::size_t>(hold) == 0) u_V = command(random);
    log.time_s.push_back(0.01 * static_cast<double>(k));
    log.command_V.push_back(u_V);
    log.volume_m3.push_back(1e-4);
    log.pressure_Pa.push_back(1e3 * (p_kPa + noise_kPa * noise(random)));
    p_kPa = next(p_kPa, u_V);
  }
  return log;
}

trace::Log of_noise(unsigned seed, std::size_t rows, double level_kPa = 300.0) {
  return log_of(
      seed, rows, 10, 0.1, [](double p, double) { return p; }, level_kPa);
}

TEST(Excitation, NoiseIsRefusedWhateverTheLength) {
  for (const std::size_t rows : {60U, 500U, 6000U}) {
    for (unsigned seed = 1; seed <= 100; ++seed) {
      EXPECT_THAT(refusal({of_noise(seed, rows)}), HasSubstr("does not move with the command"))
          << "seed " << seed << ", " << rows << " rows";
    }
  }
}

TEST(Excitation, OfNoiseSaysItsRangeAndItsStandardDeviation) {
  EXPECT_THAT(refusal({of_noise(1, 6000)}), AllOf(StartsWith("no excitation: the pressure, 299.6"),
                                                  HasSubstr(" to 300.3"), EndsWith("noise of 0.102 kPa")));
}

TEST(Excitation, LevelsOfTwoLogsAreNoMotion) {
  trace::Log low = of_noise(1, 2000, 200.0);
  trace::Log high = of_noise(2, 2000, 400.0);
  for (double& u : high.command_V) u += 2.0;
  EXPECT_THAT(refusal({low, high}), HasSubstr("does not move with the command"));
}

TEST(Excitation, APressureThatOnlyDriftsIsRefused) {
  for (const double kPa_per_tick : {-0.01, 0.001, 0.05}) {
    const auto drift = [&](double p, double) { return p + kPa_per_tick; };
    EXPECT_THAT(refusal({log_of(3, 6000, 10, 0.1, drift)}), HasSubstr("does not move with the command"))
        << kPa_per_tick;
  }
}

TEST(Excitation, ACommandThatFollowsTheNoiseIsNotFollowedByIt) {
  trace::Log log = of_noise(4, 6000);
  double sum_kPa = 0.0;
  for (std::size_t k = 0; k < log.size(); ++k) {
    const double error_kPa = 300.0 - 1e-3 * log.pressure_Pa[k];
    sum_kPa += error_kPa;
    log.command_V[k] = 5.0 + 0.5 * error_kPa + 0.01 * sum_kPa;
  }
  EXPECT_THAT(refusal({log}), HasSubstr("does not move with the command"));
}

TEST(Excitation, AChamberThatRunsFromEndToEndInATickIsAccepted) {
  for (const int hold : {1, 2, 7}) {
    const auto fast = [](double p, double u) {
      return p + (360.0 + 260.0 * std::tanh(3.0 * (u - 5.0)) - p) * 0.99;
    };
    EXPECT_EQ(refusal({log_of(5, 2000, hold, 0.1, fast)}), "accepted") << hold << " ticks a command";
  }
}

TEST(Excitation, AChamberThatMovesAHundredthOfItsNoiseInATickIsAccepted) {
  const auto slow = [](double p, double u) { return p + 0.01 * (u - 5.0); };
  EXPECT_EQ(refusal({log_of(6, 6000, 30, 1.0, slow)}), "accepted");
}

TEST(Excitation, TwoStepsOfTheCommandAreEnough) {
  trace::Log log = of_noise(7, 600);
  double p_kPa = 300.0;
  for (std::size_t k = 0; k < log.size(); ++k) {
    log.command_V[k] = k < 300 ? 6.0 : 4.0;
    log.pressure_Pa[k] += 1e3 * (p_kPa - 300.0);
    p_kPa += ((k < 300 ? 600.0 : 110.0) - p_kPa) * 0.05;
  }
  EXPECT_EQ(refusal({log}), "accepted");
}

/// A log whose volume swings by that share at so many hertz, and `gained_kPa` beside its adiabatic compression.
trace::Log swinging(unsigned seed, double share, double at_Hz, double noise_kPa,
                    const std::function<double(double u_V)>& gained_kPa) {
  trace::Log log = log_of(seed, 6000, 30, 0.0, [](double p, double) { return p; });
  std::mt19937_64 random(seed + 1000);
  std::normal_distribution<double> noise(0.0, noise_kPa);
  double p_kPa = 300.0;
  for (std::size_t k = 0; k < log.size(); ++k) {
    log.volume_m3[k] = 3e-3 * (1.0 + share * std::sin(2.0 * std::numbers::pi * at_Hz * log.time_s[k]));
    if (k > 0) p_kPa *= std::pow(log.volume_m3[k - 1] / log.volume_m3[k], 1.4);
    log.pressure_Pa[k] = 1e3 * (p_kPa + noise(random));
    p_kPa += gained_kPa(log.command_V[k]);
  }
  return log;
}

TEST(Excitation, ALargeChamberThatItsVolumeMovesFarMoreThanItsValveIsAccepted) {
  for (const double share : {0.1, 0.2, 0.3}) {
    for (const double at_Hz : {0.3, 1.0}) {
      const auto valve = [](double u) { return 0.03 * (u - 5.0); };
      EXPECT_EQ(refusal({swinging(9, share, at_Hz, 0.1, valve)}), "accepted")
          << share << " at " << at_Hz << " Hz";
    }
  }
}

TEST(Excitation, AShutChamberWhoseVolumeMovesIsRefused) {
  const auto shut = [](double) { return 0.0; };
  for (unsigned seed = 1; seed <= 100; ++seed) {
    EXPECT_THAT(refusal({swinging(seed, 0.2, 1.0, 0.1, shut)}),
                AllOf(HasSubstr("does not move with the command"), HasSubstr("noise of 0.")))
        << "seed " << seed;
  }
}

TEST(Excitation, AVolumeThatThePressureMovesLeavesTheCommandItsPart) {
  const auto slow = [](double p, double u) { return p + 0.01 * (u - 5.0); };
  trace::Log log = log_of(10, 6000, 30, 0.0, slow);
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise_Pa(0.0, 100.0);
  for (std::size_t k = 0; k < log.size(); ++k) {
    log.volume_m3[k] = 1e-4 * std::sqrt(log.pressure_Pa[k] / 3e5);
    log.pressure_Pa[k] += noise_Pa(random);
  }
  EXPECT_EQ(refusal({log}), "accepted");
}

TEST(Excitation, APressureWithoutNoiseIsAccepted) {
  EXPECT_EQ(refusal({record({})}), "accepted");
}

TEST(Excitation, WhatRestsIsNamedWithItsValue) {
  trace::Log log = record({});
  trace::Log still = log;
  std::fill(still.command_V.begin(), still.command_V.end(), 5.0);
  EXPECT_EQ(refusal({still}), "no excitation: the command is 5 V throughout");
  still = log;
  std::fill(still.pressure_Pa.begin(), still.pressure_Pa.end(), 2e5);
  EXPECT_EQ(refusal({still}), "no excitation: the pressure is 200 kPa throughout");
  std::fill(log.volume_m3.begin(), log.volume_m3.end(), 0.0);
  EXPECT_EQ(refusal({log}), "volume is 0 mL, expected above 0");
}

}  // namespace
}  // namespace plenum::host::identify
