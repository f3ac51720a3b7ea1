#include "host-sim/identify/fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/trace/respiraworks.hpp"
#include "tests/identify/chamber_of_record.hpp"

namespace plenum::host::identify {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Tassa9Fit fit(const Recording& recording, const FitOptions& options = {}) {
  return fit_tassa9({record(recording)}, rig_of(recording), options);
}

TEST(Fit, RecoversAChamberAtRestFromCleanData) {
  for (const double average_s : {0.0, 0.01}) {
    Recording recording;
    recording.c[3] = recording.c[4] = recording.c[5] = 0.0;
    recording.c[6] = 8.0;
    recording.average_s = average_s;
    const Tassa9Fit got = fit(recording);
    for (const std::size_t i : {0U, 1U, 2U, 6U, 7U, 8U}) {
      EXPECT_NEAR(got.model.c[i], recording.c[i], 1e-5 * std::abs(recording.c[i])) << "c" << i + 1;
      EXPECT_TRUE(got.parameters[i].identifiable) << "c" << i + 1;
    }
    for (const std::size_t i : {3U, 4U, 5U}) {
      EXPECT_TRUE(got.parameters[i].held) << "c" << i + 1;
      EXPECT_FALSE(got.parameters[i].identifiable) << "c" << i + 1;
      EXPECT_EQ(got.model.c[i], 0.0) << "c" << i + 1;
    }
    EXPECT_TRUE(got.converged);
    EXPECT_LT(got.rms_one_step_kPa, 1e-4);
    EXPECT_LT(got.rms_free_run_kPa, 1e-4);
  }
}

TEST(Fit, RecoversAChamberWhoseVolumeMovesFromCleanData) {
  Recording recording;
  recording.volume_mL = moving_volume_mL;
  recording.volume_held_in_tick = true;
  const Tassa9Fit got = fit(recording);
  for (std::size_t i = 0; i < kFree; ++i) {
    EXPECT_NEAR(got.model.c[i], recording.c[i], 2e-3 * std::abs(recording.c[i])) << "c" << i + 1;
    EXPECT_TRUE(got.parameters[i].identifiable) << "c" << i + 1;
  }
}

TEST(Fit, RecoversAChamberOfTheRepairedFormFromCleanData) {
  Recording recording;
  recording.volume_mL = moving_volume_mL;
  recording.volume_held_in_tick = true;
  recording.repaired = true;
  recording.c[kC4] = 0.0;
  FitOptions options;
  options.form = Form::repaired;
  const Tassa9Fit got = fit(recording, options);
  for (std::size_t i = 0; i < kFree; ++i) {
    if (i == kC4) continue;
    EXPECT_NEAR(got.model.c[i], recording.c[i], 2e-3 * std::abs(recording.c[i])) << "c" << i + 1;
    EXPECT_TRUE(got.parameters[i].identifiable) << "c" << i + 1;
  }
  EXPECT_EQ(got.model.c[kC4], 0.0);
  EXPECT_EQ(got.model.form, Form::repaired);
  EXPECT_GT(fit(recording).rms_free_run_kPa, 10.0 * got.rms_free_run_kPa) << "the published form is another";
}

TEST(Fit, HoldingTheVolumeOverATickCostsLessThanATenthOfAPercentOfSpan) {
  Recording recording;
  recording.volume_mL = moving_volume_mL;
  EXPECT_LT(fit(recording).rms_free_run_kPa, 0.52) << "[kPa]";
}

TEST(Fit, StandardErrorsMatchTheScatterOfRepeatedRecordings) {
  constexpr int kRepeats = 200;
  std::array<double, kFree> sum{}, square{}, stated{};
  Recording recording;
  recording.c[3] = recording.c[4] = recording.c[5] = 0.0;
  recording.c[6] = 8.0;
  recording.noise_kPa = 1.0;
  recording.rows = 1000;
  FitOptions options;
  options.start = Tassa9{};
  options.start->c = recording.c;
  options.explore = false;
  trace::Log log = record(recording);
  recording.noise_kPa = 0.0;
  const trace::Log clean = record(recording);
  std::mt19937_64 random(17);
  std::normal_distribution<double> noise_Pa(0.0, 1000.0);
  for (int k = 0; k < kRepeats; ++k) {
    for (std::size_t i = 0; i < log.size(); ++i) log.pressure_Pa[i] = clean.pressure_Pa[i] + noise_Pa(random);
    log.command_V = clean.command_V;
    const Tassa9Fit got = fit_tassa9({log}, rig_of(recording), options);
    for (const std::size_t i : {0U, 1U, 2U, 6U, 7U, 8U}) {
      sum[i] += got.model.c[i];
      square[i] += got.model.c[i] * got.model.c[i];
      stated[i] += got.parameters[i].standard_error;
    }
  }
  for (const std::size_t i : {0U, 1U, 2U, 6U, 7U, 8U}) {
    const double mean = sum[i] / kRepeats;
    const double scatter = std::sqrt((square[i] - kRepeats * mean * mean) / (kRepeats - 1));
    // The scatter of 200 repeats is itself known to 5 %; four of those.
    EXPECT_NEAR(stated[i] / kRepeats / scatter, 1.0, 0.2) << "c" << i + 1 << ", seed 17";
    EXPECT_NEAR(mean, recording.c[i], 4.0 * scatter / std::sqrt(1.0 * kRepeats) + 0.1 * scatter)
        << "bias of c" << i + 1;
  }
}

TEST(Fit, ARateInverseToVolumePutsC6AtItsBoundAndSaysSo) {
  Recording recording;
  recording.volume_mL = moving_volume_mL;
  recording.c[5] = 1e4;
  recording.c[4] = 1.4e4;
  recording.c[6] = 9.0 * 1.2e6;
  const Tassa9Fit got = fit(recording);
  EXPECT_EQ(got.parameters[5].at_bound, Bound::high);
  EXPECT_FALSE(got.parameters[5].identifiable);
  EXPECT_TRUE(std::isnan(got.parameters[5].standard_error));
  EXPECT_NEAR(got.model.c[5], 1000.0 / 120.0, 1.0) << "[1/mL]";
}

/// Commands and volumes of a recording with pressures that no chamber gives: a random walk between supply and
/// ambient, pushed a little by the command.
trace::Log nonsense(unsigned seed) {
  Recording recording;
  recording.volume_mL = moving_volume_mL;
  recording.seed = seed;
  recording.rows = 600;
  trace::Log log = record(recording);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise;
  double p = 3e5;
  for (std::size_t k = 0; k < log.size(); ++k) {
    log.pressure_Pa[k] = p;
    p = std::clamp(p + 2e4 * noise(random) + 2e4 * (log.command_V[k] - 5.0), 1.1e5, 6e5);
  }
  return log;
}

TEST(Fit, WhateverTheDataTheModelStaysAdmissible) {
  int fitted = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Tassa9Fit got;
    try {
      got = fit_tassa9({nonsense(seed)}, rig_of({}));
    } catch (const CannotIdentify&) {
      continue;  // refusing is an answer too
    }
    ++fitted;
    const auto& c = got.model.c;
    EXPECT_GE(c[0], 2.0);
    EXPECT_LE(c[0], 8.0);
    EXPECT_GT(c[2], -1.0);
    EXPECT_LT(std::abs(c[7]), 1.0);
    EXPECT_GT(c[8], 0.1 * (1.0 - std::sqrt(1.0 - c[7] * c[7]))) << "k > 0, seed " << seed;
    double before = -1.0;
    for (double u = 0.0; u <= 10.0; u += 0.01) {
      const SteadyAndRate at = steady_and_rate(got.model, u, 120.0, 0.0);
      EXPECT_GT(at.rate_per_s, 0.0) << u << " [V], seed " << seed;
      EXPECT_GE(at.steady_kPa, before - 1e-9) << u << " [V], seed " << seed;
      before = at.steady_kPa;
    }
  }
  EXPECT_GE(fitted, 5) << "of 10";
}

TEST(Fit, EveryRandomStartEndsInTheSameMinimum) {
  Recording recording;
  recording.volume_mL = moving_volume_mL;
  recording.noise_kPa = 0.5;
  const std::vector<trace::Log> logs{record(recording)};
  FitOptions options;
  options.refine_free_run = false;
  const double best = fit_tassa9(logs, rig_of(recording), options).cost_kPa2;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit;
  for (const bool explore : {true, false}) {
    options.explore = explore;
    for (int k = 0; k < 15; ++k) {
      std::array<double, kFree> draw{};
      for (double& x : draw) x = unit(random);
      options.start = start_within_bounds(draw, logs, rig_of(recording));
      EXPECT_NEAR(fit_tassa9(logs, rig_of(recording), options).cost_kPa2 / best, 1.0, 1e-6)
          << "seed 7, start " << k << ", explore " << explore;
    }
  }
}

TEST(Fit, SeveralLogsAtRestAtDifferentVolumesTellC6) {
  Recording recording;
  recording.c[3] = recording.c[4] = 0.0;
  recording.c[5] = 0.02;
  recording.c[6] = 30.0;
  std::vector<trace::Log> logs;
  for (const double volume_mL : {60.0, 120.0, 240.0}) {
    recording.volume_mL = [=](double) { return volume_mL; };
    recording.seed += 1;
    logs.push_back(record(recording));
  }
  const Tassa9Fit got = fit_tassa9(logs, rig_of(recording));
  EXPECT_NEAR(got.model.c[5], 0.02, 1e-5) << "[1/mL]";
  EXPECT_TRUE(got.parameters[3].held);
  EXPECT_TRUE(got.parameters[4].held);
  EXPECT_FALSE(got.parameters[5].held);
}

std::string refusal(const trace::Log& log) {
  try {
    fit_tassa9({log}, rig_of({}));
  } catch (const CannotIdentify& error) {
    return error.what();
  }
  return "fitted";
}

TEST(Fit, SaysInOneLineWhyItCannot) {
  trace::Log log = record({});
  trace::Log still = log;
  std::fill(still.command_V.begin(), still.command_V.end(), 5.0);
  EXPECT_THAT(refusal(still), HasSubstr("no excitation: the command is 5 V"));
  still = log;
  std::fill(still.pressure_Pa.begin(), still.pressure_Pa.end(), 2e5);
  EXPECT_THAT(refusal(still), HasSubstr("no excitation: the pressure is 200 kPa"));
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise_Pa(0.0, 100.0);
  for (double& p : still.pressure_Pa) p += noise_Pa(random);
  EXPECT_THAT(refusal(still), HasSubstr("does not move with the command beyond its noise of 0.1"));
  Recording brief;
  brief.rows = 40;
  EXPECT_THAT(refusal(record(brief)), HasSubstr("too short"));
  // Two commands only: the kink c3 cannot be told from the slope c2.
  trace::Log two = log;
  for (double& u : two.command_V) u = u > 5.0 ? 5.5 : 4.5;
  EXPECT_THAT(refusal(two), HasSubstr("rank-deficient"));
}

// As from a log that was split where rows are missing: what was sent before its first row is not known.
TEST(Fit, LeavesOutWhatCommandsFromBeforeALogDo) {
  Recording recording;
  recording.c[3] = recording.c[4] = recording.c[5] = 0.0;
  recording.c[6] = 8.0;
  recording.dead_time_s = 0.08;
  const trace::Log whole = record(recording);
  std::vector<trace::Log> parts;
  for (std::size_t from = 37; from + 100 <= whole.size(); from += 100) {
    trace::Log& part = parts.emplace_back();
    const auto cut = [&](const std::vector<double>& all) {
      const auto first = all.begin() + static_cast<std::ptrdiff_t>(from);
      return std::vector<double>(first, first + 100);
    };
    part.time_s = cut(whole.time_s);
    part.command_V = cut(whole.command_V);
    part.pressure_Pa = cut(whole.pressure_Pa);
    part.volume_m3 = cut(whole.volume_m3);
  }
  FitOptions options;
  options.dead_time_s = recording.dead_time_s;
  options.stretch_s = 0.2;
  const Tassa9Fit got = fit_tassa9(parts, rig_of(recording), options);
  EXPECT_LT(got.rms_one_step_kPa, 1e-3);
  EXPECT_LT(got.rms_free_run_kPa, 1e-3);
  EXPECT_NEAR(got.model.c[6], recording.c[6], 1e-4);
}

// All that is fitted ends at a bound then; there is no curvature left to speak of.
TEST(Fit, TwoCommandsOfTheWrongSignAreRefused) {
  FitOptions options;
  options.stretch_s = 0.2;
  EXPECT_THROW(fit_tassa9({of_two_commands(true)}, rig_of({}), options), CannotIdentify);
}

TEST(Fit, AValveWhoseNullTheFormHasNotIsRefusedWhereTheCommandsPassIt) {
  trace::Log log = record({});
  for (double& u : log.command_V) u = 2.4 * u;
  trace::RigDescription rig = rig_of({});
  rig.valve.open_above_V = 12.1;
  rig.valve.exhaust_below_V = 11.9;
  EXPECT_THAT([&] { fit_tassa9({log}, rig); },
              testing::ThrowsMessage<CannotIdentify>(AllOf(HasSubstr("c1_V within 2 and 8 V"),
                                                           HasSubstr("below 11.9 and above 12.1 V"),
                                                           HasSubstr("grey-box"))));
  EXPECT_NO_THROW(fit_tassa9({record({})}, rig)) << "on one side of it";
  log = record({});
  for (double& u : log.command_V) u -= 4.0;
  rig.valve.open_above_V = 1.1;
  rig.valve.exhaust_below_V = 0.9;
  EXPECT_NO_THROW(fit_tassa9({log}, rig)) << "a pump's flank";
}

TEST(Fit, TheModelFileHoldsParametersAndWhatIsKnownOfThem) {
  Recording recording;
  recording.noise_kPa = 0.5;
  const Tassa9Fit got = fit(recording);
  const trace::ModelFile file = trace::parse_model(trace::format_model(to_model_file(got, 4)), "m.json");
  EXPECT_THAT(file.parameters, testing::ElementsAreArray(got.model.image()));
  EXPECT_EQ(file.chamber, 4U);
  EXPECT_EQ(file.fit["parameters"]["c6_per_mL"]["held"], true);
  EXPECT_TRUE(file.fit["parameters"]["c6_per_mL"]["standard_error"].is_null());
  EXPECT_GT(file.fit["parameters"]["c1_V"]["standard_error"].get<double>(), 0.0);
}

TEST(Fit, TheFileOfARepairedFormNamesItsKindAndHasNoC4) {
  FitOptions options;
  options.form = Form::repaired;
  Recording recording;
  recording.noise_kPa = 0.5;
  const Tassa9Fit got = fit(recording, options);
  const trace::ModelFile file = trace::parse_model(trace::format_model(to_model_file(got, 4)), "m.json");
  EXPECT_EQ(file.kind, "tassa9r");
  EXPECT_THAT(file.parameters, testing::ElementsAreArray(got.model.image()));
  EXPECT_EQ(file.parameters.size(), 12U);
  EXPECT_EQ(file.fit["parameters"].size(), 9U) << "with the dead time";
  EXPECT_FALSE(file.fit["parameters"].contains("c4_kPa_s_per_mL"));
}

TEST(FitOnMeasuredRuns, PredictsRunsItHasNotSeenBetterThanHoldingThePressure) {
  const std::string folder = std::string(PLENUM_SOURCE_DIR) + "/tests/data/respiraworks/ctl_OXY_";
  const auto run = [&](int test) {
    return trace::import_respiraworks(folder + std::to_string(test) + ".csv");
  };
  trace::RigDescription rig;
  rig.supply.pressure_Pa = 110e3;
  const Tassa9Fit got = fit_tassa9({run(1), run(3), run(5)}, rig);
  EXPECT_TRUE(got.converged);
  for (const int test : {2, 4, 6}) {
    const trace::Log log = run(test);
    double held = 0.0;
    for (std::size_t k = 1; k < log.size(); ++k) {
      held += std::pow(1e-3 * (log.pressure_Pa[k] - log.pressure_Pa[(k - 1) / 200 * 200]), 2);
    }
    held = std::sqrt(held / static_cast<double>(log.size() - 1));
    EXPECT_LT(free_run_rms_kPa(got.model, log), 0.5 * held) << "[kPa], run " << test;
  }
}

}  // namespace
}  // namespace plenum::host::identify
