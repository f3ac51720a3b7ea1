#include "host-sim/identify/profile.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host-sim/identify/cannot_identify.hpp"
#include "tests/identify/chamber_of_record.hpp"

namespace plenum::host::identify {
namespace {

/// A chamber whose volume moves, in 40 s with a sensor's noise, behind a valve that is so late.
Recording late_by(double dead_time_s) {
  Recording recording;
  recording.volume_mL = moving_volume_mL;
  recording.noise_kPa = 0.1;
  recording.rows = 4000;
  recording.dead_time_s = dead_time_s;
  return recording;
}

Tassa9Fit fit(const trace::Log& log, const Recording& of = {}, const Profiled& profiled = {}) {
  FitOptions options;
  options.stretch_s = 0.2;
  return fit_tassa9_profiled({log}, rig_of(of), options, profiled);
}
Tassa9Fit fit(const Recording& recording, const Profiled& profiled = {}) {
  return fit(record(recording), recording, profiled);
}

// 0.3 ms: between whole ticks the mean of two commands stands for one after the other.
TEST(Profile, FindsTheDeadTimeOfALateValve) {
  for (const double dead_time_s : {0.0, 0.0045, 0.012, 0.025, 0.06, 0.118}) {
    const Recording recording = late_by(dead_time_s);
    const Tassa9Fit got = fit(recording);
    EXPECT_NEAR(got.model.dead_time_s, dead_time_s, 3e-4) << "s";
    EXPECT_EQ(got.model.c_gamma_V, recording.c_gamma_V) << "V, late by " << dead_time_s << " s";
    EXPECT_NEAR(got.model.c[0], recording.c[0], 0.02) << "c1 [V], late by " << dead_time_s << " s";
  }
}

// What the published form misses of a volume that moves with the command looks like lateness to it.
TEST(Profile, FindsTheSameDeadTimeWhicheverFormIsFitted) {
  for (const double dead_time_s : {0.0, 0.02, 0.04}) {
    Recording recording = late_by(dead_time_s);
    recording.repaired = true;
    recording.c[kC4] = 0.0;
    recording.volume_mL = [](double t) { return 120.0 + 36.0 * std::sin(6.0 * t); };
    recording.command_V = [](double t) {
      return 5.0 + 0.6 * std::sin(6.0 * t + 0.5) + 0.2 * std::sin(17.0 * t);
    };
    EXPECT_NEAR(fit(recording).model.dead_time_s, dead_time_s, 5e-4) << "s";
  }
}

TEST(Profile, TakesADeadTimeThatIsKnown) {
  const Recording recording = late_by(0.025);
  const Profiled known{.kink_width = true, .dead_time = false};
  const Tassa9Fit prompt = fit(recording, known), found = fit(recording);
  EXPECT_EQ(prompt.model.dead_time_s, 0.0);
  EXPECT_TRUE(prompt.dead_time.held);
  EXPECT_TRUE(!found.dead_time.held && found.dead_time.identifiable);
  EXPECT_GT(prompt.rms_one_step_kPa, 4.0 * found.rms_one_step_kPa) << "kPa";
}

// A dead time at which a wrong model happens to be told is none of these logs.
TEST(Profile, WhereTheBestDeadTimeTellsNoModelNoOtherIsTaken) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    EXPECT_THAT([&] { fit(of_two_commands(false, seed)); },
                testing::ThrowsMessage<CannotIdentify>(testing::HasSubstr("rank-deficient")))
        << "seed " << seed;
  }
}

// Half a tick of a chamber that is through with a step in a tick is nothing like a tick of half the step.
TEST(Profile, AWholeTickStaysTheBestWherePartsOfOneFitWorse) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> command_V(0.0, 10.0);
    std::uniform_int_distribution<int> dwell(3, 30);
    const Recording chamber;
    trace::Log log = of_two_commands(false, seed);
    log.pressure_average_s = 0.0;
    double p_kPa = 250.0, u_V = 5.0;
    int left = 0;
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (left-- == 0) {
        u_V = command_V(random);
        left = dwell(random);
      }
      log.command_V[k] = u_V;
      log.pressure_Pa[k] = 1e3 * p_kPa;
      p_kPa += (1.0 - std::exp(-std::abs(u_V - 5.0))) *
               ((u_V > 5.0 ? chamber.supply_kPa : chamber.ambient_kPa) - p_kPa);
    }
    EXPECT_EQ(fit(log).model.dead_time_s, 0.0) << "s, seed " << seed;
  }
}

/// A chamber that follows a ramp of 20 s within seconds: no dead time shows beyond the sensor's noise.
trace::Log of_slow_ramps(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise_kPa(0.0, 1.0);
  trace::Log log = of_two_commands(false);
  double p_kPa = 250.0;
  for (std::size_t k = 0; k < log.size(); ++k) {
    const double along = std::fmod(static_cast<double>(k) / 1000.0, 2.0);
    log.command_V[k] = 4.65 + 0.7 * std::min(along, 2.0 - along);
    log.pressure_Pa[k] = 1e3 * (p_kPa + noise_kPa(random));
    p_kPa += 0.01 * (360.0 + 500.0 * (log.command_V[k] - 5.0) - p_kPa);
  }
  return log;
}

TEST(Profile, ADeadTimeThatTheLogDoesNotTellIsNoneAndPoorlyKnown) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    const Tassa9Fit got = fit(of_slow_ramps(seed));
    EXPECT_LT(got.model.dead_time_s, 1e-3) << "s, a tenth of a tick, seed " << seed;
    EXPECT_GT(got.dead_time.standard_error, 0.01) << "s, seed " << seed;
    EXPECT_FALSE(got.dead_time.identifiable) << "seed " << seed;
  }
}

TEST(Profile, TheStandardErrorOfADeadTimeIsTheScatterOfRepeatedRecordings) {
  constexpr int kRecordings = 12;
  double sum_s = 0.0, squares_s2 = 0.0, expected_s2 = 0.0;
  for (unsigned seed = 1; seed <= kRecordings; ++seed) {
    Recording recording = late_by(0.025);
    recording.volume_mL = [](double) { return 120.0; };
    recording.c[3] = recording.c[4] = recording.c[5] = 0.0;
    recording.c[6] = 2.0;
    recording.noise_kPa = 2.0;
    recording.rows = 1000;
    recording.seed = seed;
    const Tassa9Fit got = fit(recording, {.kink_width = false, .dead_time = true});
    EXPECT_EQ(got.dead_time.value, got.model.dead_time_s);
    EXPECT_TRUE(got.dead_time.identifiable) << "seed " << seed;
    sum_s += got.dead_time.value;
    squares_s2 += std::pow(got.dead_time.value, 2);
    expected_s2 += std::pow(got.dead_time.standard_error, 2) / kRecordings;
  }
  const double mean_s = sum_s / kRecordings;
  const double scatter_s = std::sqrt((squares_s2 - kRecordings * mean_s * mean_s) / (kRecordings - 1));
  EXPECT_NEAR(mean_s, 0.025, 1e-3) << "s";
  EXPECT_GT(scatter_s / std::sqrt(expected_s2), 0.5);
  EXPECT_LT(scatter_s / std::sqrt(expected_s2), 1.5);
}

TEST(Profile, AValveThatIsLaterThanABoardCanLookOverIsAtItsBound) {
  const Tassa9Fit got = fit(late_by(0.15));
  EXPECT_EQ(got.model.dead_time_s, trace::kLongestDeadTime_s) << "s";
  EXPECT_EQ(got.dead_time.at_bound, Bound::high);
  EXPECT_FALSE(got.dead_time.identifiable);
}

TEST(Profile, WithoutAFitSaysWhy) {
  Recording still = late_by(0.0);
  trace::Log log = record(still);
  for (double& command : log.command_V) command = 5.0;
  EXPECT_THROW(fit_tassa9_profiled({log}, rig_of(still)), CannotIdentify);
}

}  // namespace
}  // namespace plenum::host::identify
