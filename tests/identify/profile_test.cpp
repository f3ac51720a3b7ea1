#include "host-sim/identify/profile.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

Tassa9Fit fit(const Recording& recording, const Profiled& profiled = {}) {
  FitOptions options;
  options.stretch_s = 0.2;
  return fit_tassa9_profiled({record(recording)}, rig_of(recording), options, profiled);
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

TEST(Profile, TakesADeadTimeThatIsKnown) {
  const Recording recording = late_by(0.025);
  const Profiled known{.kink_width = true, .dead_time = false};
  const Tassa9Fit prompt = fit(recording, known), found = fit(recording);
  EXPECT_EQ(prompt.model.dead_time_s, 0.0);
  EXPECT_GT(prompt.rms_one_step_kPa, 4.0 * found.rms_one_step_kPa) << "kPa";
}

TEST(Profile, WithoutAFitSaysWhy) {
  Recording still = late_by(0.0);
  trace::Log log = record(still);
  for (double& command : log.command_V) command = 5.0;
  EXPECT_THROW(fit_tassa9_profiled({log}, rig_of(still)), CannotIdentify);
}

}  // namespace
}  // namespace plenum::host::identify
