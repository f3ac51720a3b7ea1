// The regulator on chambers that differ from its model in known ways.
#include "firmware/control/regulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "firmware/control/tassa9.hpp"
#include "tests/firmware/control/paper_chamber.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

using Chamber = testing::PaperChamber;

/// The defaults, for a valve that answers at once.
Regulator::Config prompt_valve() {
  Regulator::Config config;
  config.valve_delay_ticks = 0;
  return config;
}

struct Loop {
  Tassa9 model;
  Regulator regulator;
  Chamber chamber;
  double measured_kPa = 300;
  double command_V = 5;
  ChamberMotion motion{.volume_mL = 150, .volume_rate_mL_s = 0};

  explicit Loop(const Regulator::Config& config = prompt_valve()) {
    model.configure(scalars(testing::kMpyeLike), 3, 7);
    regulator.configure(config);
    regulator.reset(300, 5);
  }

  /// One tick with reference r(t), t in ticks. Returns the pressure at its end.
  double tick(const std::function<double(double)>& reference, double t, const ChamberMotion& past,
              const ChamberMotion& next) {
    regulator.observe(model, static_cast<float>(measured_kPa), past);
    ReferenceShaper::Reference wanted;
    for (std::size_t i = 0; i < wanted.kPa.size(); ++i)
      wanted.kPa[i] = static_cast<float>(reference(t + static_cast<double>(i)));
    const Regulator::Command command = regulator.regulate(model, wanted, next);
    command_V = static_cast<double>(command.command_V);
    regulator.sent(command.command_V);
    measured_kPa = chamber.tick(command_V, static_cast<double>(next.volume_mL),
                                static_cast<double>(next.volume_rate_mL_s));
    return chamber.pressure_kPa;
  }
  double tick(const std::function<double(double)>& reference, double t) {
    return tick(reference, t, motion, motion);
  }
};

Regulator::Config without_learning() {
  Regulator::Config config = prompt_valve();
  config.disturbance_deviation_kPa = 0;
  config.compression_deviation = 0;
  config.trim_deviation_V = 0;
  return config;
}

TEST(Regulator, OnItsOwnModelItLandsOnTheReferenceInOneTick) {
  Loop loop(without_learning());
  const auto reference = [](double t) { return t < 10 ? 300.0 : 306.0; };
  double end = 0;
  for (int t = 0; t < 10; ++t) end = loop.tick(reference, t);
  EXPECT_NEAR(end, 306.0, 0.02) << "kPa: the first tick that ends after the step";
  EXPECT_NEAR(loop.tick(reference, 10), 306.0, 0.02) << "kPa: and it stays";
}

TEST(Regulator, OnItsOwnModelItFollowsASineWithPreviewToTheResolutionOfTheInverse) {
  Loop loop(without_learning());
  const auto reference = [](double t) { return 300 + 80 * std::sin(2 * std::numbers::pi * 0.02 * t); };
  double worst = 0;
  for (int t = 0; t < 300; ++t) {
    const double end = loop.tick(reference, t);
    if (t > 5) worst = std::max(worst, std::fabs(end - reference(t + 1)));
  }
  EXPECT_LT(worst, 0.05) << "kPa, 2 Hz";
}

// A valve that answers after four ticks and a third: were they forgotten, the error would go from 0.5 to 3 kPa.
TEST(Regulator, AModelThatComesIntoForceAtWorkKnowsOfTheCommandsOnTheirWay) {
  const auto reference = [](double t) { return 300 + 120 * std::sin(2 * std::numbers::pi * 0.02 * t); };
  const ValvePath::Config valve{.dead_ticks = 4.3F, .lag_ticks = 0, .play_V = 0};
  const auto worst_kPa = [&](bool comes_anew) {
    Loop loop(without_learning());
    loop.chamber.delay_ticks = 4.3;
    loop.regulator.take_over(valve, Scalar(0));
    loop.regulator.reset(300, 5);
    double worst = 0;
    for (int t = 0; t < 250; ++t) {
      if (comes_anew && t == 200) {
        loop.regulator.take_over(valve, Scalar(0));
        loop.regulator.go_on(loop.regulator.pressure_kPa());
      }
      const double end = loop.tick(reference, t);
      if (t >= 195) worst = std::max(worst, std::fabs(end - reference(t + 1)));
    }
    return worst;
  };
  EXPECT_LT(worst_kPa(true), worst_kPa(false) + 0.05) << "kPa";
}

TEST(Regulator, AnUnknownLeakLeavesNoSteadyError) {
  Loop loop;
  loop.chamber.leak_kPa_s = -200;
  const auto reference = [](double) { return 400.0; };
  double end = 0;
  for (int t = 0; t < 400; ++t) end = loop.tick(reference, t);
  EXPECT_NEAR(end, 400.0, 0.2) << "kPa";
}

TEST(Regulator, AShiftedValveIsLearned) {
  Loop loop;
  loop.chamber.valve_offset_V = 0.3;
  const auto reference = [](double t) { return 300 + 80 * std::sin(2 * std::numbers::pi * 0.02 * t); };
  double first = 0;
  double last = 0;
  for (int t = 0; t < 2'000; ++t) {
    const double error = loop.tick(reference, t) - reference(t + 1);
    if (t < 50) first += error * error / 50;
    if (t >= 1'950) last += error * error / 50;
  }
  EXPECT_LT(std::sqrt(last), 0.2 * std::sqrt(first))
      << "RMS [kPa] before " << std::sqrt(first) << ", after " << std::sqrt(last);
}

TEST(Regulator, TheCompressionThatTheModelLeavesOutIsLearned) {
  Loop loop;
  const auto reference = [](double) { return 350.0; };
  const auto motion_at = [](double t) -> ChamberMotion {
    const double angle = 2 * std::numbers::pi * 0.01 * t;
    return {.volume_mL = static_cast<float>(150 + 30 * std::sin(angle)),
            .volume_rate_mL_s = static_cast<float>(30 * 2 * std::numbers::pi * std::cos(angle))};
  };
  double first = 0;
  double last = 0;
  for (int t = 0; t < 2'000; ++t) {
    const double error = loop.tick(reference, t, motion_at(t - 0.5), motion_at(t + 0.5)) - 350.0;
    if (t >= 5 && t < 55) first += error * error / 50;
    if (t >= 1'950) last += error * error / 50;
  }
  EXPECT_LT(std::sqrt(last), 0.35 * std::sqrt(first))
      << "RMS [kPa] before " << std::sqrt(first) << ", after " << std::sqrt(last);
}

TEST(Regulator, NothingWindsUpWhileTheCommandIsAtItsLimit) {
  Loop loop;
  // Two seconds of a pressure that the supply does not have, then one that it has.
  const auto reference = [](double t) { return t < 200 ? 650.0 : 450.0; };
  double lowest = 1e9;
  for (int t = 0; t < 300; ++t) {
    const double end = loop.tick(reference, t);
    if (t >= 205) lowest = std::min(lowest, end);
    if (t >= 215) {
      EXPECT_NEAR(end, 450.0, 5.0) << "kPa at tick " << t;
    }
  }
  EXPECT_GT(lowest, 440.0) << "kPa: undershoot after the limit";
}

TEST(Regulator, ItsCommandsStayWithinTheirLimits) {
  Loop loop;
  loop.chamber.valve_offset_V = -0.5;
  for (int t = 0; t < 600; ++t) {
    loop.tick([](double x) { return 350 + 300 * std::sin(0.3 * x); }, t);
    ASSERT_GE(loop.command_V, 3.0);
    ASSERT_LE(loop.command_V, 7.0);
  }
}

TEST(Regulator, AKnownDelayOfTheValveIsCountedIn) {
  const auto rms_with = [](float believed_delay) {
    Regulator::Config config = without_learning();
    config.valve_delay_ticks = believed_delay;
    Loop loop(config);
    loop.chamber.delay_ticks = 0.4;
    // A triangle, judged beside its corners: within the tick of a corner no held command follows it.
    const auto reference = [](double t) { return 300 + 3 * std::fabs(25 - std::fmod(t, 50.0)); };
    double square = 0;
    for (int t = 0; t < 500; ++t) {
      const double error = loop.tick(reference, t) - reference(t + 1);
      if (t >= 50 && t % 25 > 2 && t % 25 < 22) square += error * error;
    }
    return std::sqrt(square);
  };
  EXPECT_LT(rms_with(0.4F), 0.2 * rms_with(0.0F))
      << "RMS [kPa] with " << rms_with(0.4F) << ", without " << rms_with(0);
}

TEST(Regulator, TellsWhatAReadingMissesHoweverTheSensorLags) {
  constexpr double kMissed_kPa = 3;
  for (const float lag_ticks : {0.0F, 0.5F, 3.0F, 20.0F}) {
    Loop loop;
    loop.regulator.take_over({.dead_ticks = 0, .lag_ticks = 0, .play_V = 0}, lag_ticks);
    loop.regulator.reset(300, 5);
    loop.regulator.sent(5);
    // a chamber that stands still behind a shut valve, as the sensor does: what the model adds in a tick is told first
    const double drift_kPa = real(loop.regulator.observe(loop.model, 300, loop.motion).residual_kPa);
    loop.regulator.reset(300, 5);
    loop.regulator.sent(5);
    const double told_kPa =
        real(loop.regulator.observe(loop.model, static_cast<float>(300 + kMissed_kPa), loop.motion)
                 .residual_kPa) -
        drift_kPa;
    EXPECT_NEAR(told_kPa, kMissed_kPa, 1e-3) << lag_ticks << " ticks";
  }
}

/// RMS error [kPa] behind a sine of 1 Hz that is known in advance, with what the regulator is told of valve and sensor.
double rms_behind_a_sine(const Chamber& chamber, const ValvePath::Config& valve, float sensor_lag_ticks) {
  Loop loop(without_learning());
  loop.chamber = chamber;
  loop.regulator.take_over(valve, sensor_lag_ticks);
  const auto reference = [](double t) { return 300 + 60 * std::sin(2 * std::numbers::pi * 0.01 * t); };
  double square = 0;
  for (int t = 0; t < 400; ++t) {
    const double error = loop.tick(reference, t) - reference(t + 1);
    if (t >= 100) square += error * error / 300;
  }
  return std::sqrt(square);
}

/// What is left of that error when the regulator is told all of the chamber's valve and sensor, as a share of it untold.
double share_left(const Chamber& chamber) {
  const ValvePath::Config valve{.dead_ticks = static_cast<float>(chamber.delay_ticks),
                                .lag_ticks = static_cast<float>(chamber.lag_ticks),
                                .play_V = static_cast<float>(chamber.play_V)};
  return rms_behind_a_sine(chamber, valve, static_cast<float>(chamber.sensor_lag_ticks)) /
         rms_behind_a_sine(chamber, {}, 0);
}

TEST(Regulator, AValveThatIsLateByTicksIsLookedAheadOf) {
  Chamber chamber;
  chamber.delay_ticks = 4.3;
  EXPECT_LT(share_left(chamber), 0.05);
}

TEST(Regulator, AHysteresisIsMadeUpForAtEachReversal) {
  Chamber chamber;
  chamber.play_V = 0.4;
  EXPECT_LT(share_left(chamber), 0.05);
}

TEST(Regulator, ASpoolThatLagsIsMadeToArrive) {
  Chamber chamber;
  chamber.lag_ticks = 1.5;
  EXPECT_LT(share_left(chamber), 0.2);
}

TEST(Regulator, WhatALaggingSensorShowsIsNotTakenForThePressure) {
  Chamber chamber;
  chamber.sensor_lag_ticks = 5;
  EXPECT_LT(share_left(chamber), 0.1);
}

TEST(Regulator, AllOfThemTogetherAreAnswered) {
  Chamber chamber;
  chamber.delay_ticks = 2.6;
  chamber.play_V = 0.2;
  chamber.lag_ticks = 1;
  chamber.sensor_lag_ticks = 3;
  EXPECT_LT(share_left(chamber), 0.1);
}

TEST(Regulator, AVolumeSensorThatJumpsAboutNeverTakesItsStateOutOfTheNumbers) {
  std::mt19937 random(77);
  std::uniform_real_distribution<float> volume_mL(-50, 300), rate_mL_s(-30000, 30000);
  for (int trial = 0; trial < 200; ++trial) {
    Loop loop{Regulator::Config{}};
    const auto motion = [&] {
      return ChamberMotion{.volume_mL = volume_mL(random), .volume_rate_mL_s = rate_mL_s(random)};
    };
    for (int t = 0; t < 300; ++t) {
      loop.regulator.observe(loop.model, 300, motion());
      ReferenceShaper::Reference wanted;
      wanted.kPa.fill(300);
      const Scalar command_V = loop.regulator.regulate(loop.model, wanted, motion()).command_V;
      loop.regulator.sent(command_V);
      ASSERT_TRUE(numeric::is_finite(loop.regulator.pressure_kPa()) && numeric::is_finite(command_V))
          << loop.regulator.pressure_kPa() << " kPa, " << command_V << " V, trial " << trial << ", tick "
          << t;
    }
  }
}

TEST(Regulator, TakesOverFromAHeldCommandWithoutABump) {
  Loop loop;
  // Somebody else holds the valve at 5.2 V; the regulator only watches.
  for (int t = 0; t < 200; ++t) {
    loop.regulator.observe(loop.model, static_cast<float>(loop.measured_kPa), loop.motion);
    loop.regulator.sent(5.2F);
    loop.measured_kPa = loop.chamber.tick(5.2, 150, 0);
  }
  const double before = loop.chamber.pressure_kPa;
  const auto here = [before](double) { return before; };
  for (int t = 0; t < 20; ++t) EXPECT_NEAR(loop.tick(here, t), before, 0.5) << "kPa at tick " << t;
}

}  // namespace
}  // namespace plenum::control
