// volume_error against the model with the true volume.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

TEST(VolumeError, IsTheModelWithTheOtherVolume) {
  const std::vector<double> command_V = jumping_command_V(800);
  for (const double offset_mL : {-60.0, 25.0, 400.0}) {
    const Drive logged = drive_of(command_V, swinging_volume(), 4);
    Drive actual = logged;
    for (double& volume : actual.volume_m3) volume += offset_mL * 1e-6;
    const std::vector<double> with_error =
        run(only(kIdVolumeError), with(nominal(), kIdVolumeError, {offset_mL}), logged, 3e5);
    const std::vector<double> other = run(0, nominal(), actual, 3e5);
    for (std::size_t k = 0; k < other.size(); ++k) {
      ASSERT_NEAR(with_error[k], other[k], 1e-5) << "Pa, row " << k << ", " << offset_mL << " mL";
    }
  }
}

TEST(VolumeError, BentIsTheModelWithTheBentVolume) {
  const std::vector<double> command_V = jumping_command_V(800);
  const Drive logged = drive_of(command_V, swinging_volume(), 4);
  const double mean_m3 = Surroundings{}.volume_m3;
  for (const auto& [bow, s_shape] : {std::pair{-0.8, 0.0}, {0.3, 0.0}, {0.2, -0.9}}) {
    Drive actual = logged;
    for (double& volume : actual.volume_m3) {
      const double way = volume / mean_m3 - 1.0;
      volume += 20e-6 + mean_m3 * (bow * std::pow(way, 2) + s_shape * std::pow(way, 3));
    }
    const std::vector<double> with_error =
        run(only(kIdVolumeError), with(nominal(), kIdVolumeError, {20.0, bow, s_shape, 0.0}), logged, 3e5);
    const std::vector<double> other = run(0, nominal(), actual, 3e5);
    for (std::size_t k = 0; k < other.size(); ++k) {
      ASSERT_NEAR(with_error[k], other[k], 20.0) << "Pa, row " << k << ", bow " << bow;
    }
  }
}

// A first-order sensor in closed form: of v = m + a sin(w t) it says m + a sin(w t - atan(w tau))/sqrt(1 + (w tau)^2) once it has settled.
TEST(VolumeError, UndoesTheLagOfAPositionSensor) {
  constexpr std::size_t kRows = 800;
  constexpr int kSteps = 4;
  constexpr double kMean_m3 = 200e-6, kSwing_m3 = 60e-6, kOmega = 2.0 * std::numbers::pi * 0.9, kLag_s = 0.03;
  Drive actual = drive_of(jumping_command_V(kRows), swinging_volume(), kSteps);
  Drive logged = actual;
  const double slower = std::atan(kOmega * kLag_s),
               smaller = 1.0 / std::sqrt(1.0 + std::pow(kOmega * kLag_s, 2));
  for (std::size_t i = 0; i < actual.volume_m3.size(); ++i) {
    const double angle = kOmega * 0.01 / kSteps * static_cast<double>(i);
    actual.volume_m3[i] = kMean_m3 + kSwing_m3 * std::sin(angle);
    logged.volume_m3[i] = kMean_m3 + kSwing_m3 * smaller * std::sin(angle - slower);
  }
  const std::vector<double> expected = run(0, nominal(), actual, 3e5);
  const std::vector<double> late = run(0, nominal(), logged, 3e5);
  const std::vector<double> undone =
      run(only(kIdVolumeError), with(nominal(), kIdVolumeError, {0.0, 0.0, 0.0, kLag_s}), logged, 3e5);
  double late_squares = 0.0, undone_squares = 0.0;
  for (std::size_t k = 0; k < kRows; ++k) {
    late_squares += std::pow(late[k] - expected[k], 2);
    undone_squares += std::pow(undone[k] - expected[k], 2);
  }
  EXPECT_GT(std::sqrt(late_squares / kRows), 3e3) << "Pa";
  EXPECT_LT(std::sqrt(undone_squares / late_squares), 0.03);
}

TEST(VolumeError, UndoesTheDeadTimeOfAPositionSensor) {
  const std::vector<double> command_V = jumping_command_V(800);
  const plant::VolumeMotion motion = swinging_volume();
  const Drive actual = drive_of(command_V, motion, 4);
  for (const double delay_s : {0.03, 0.0741}) {
    Drive logged = actual;
    for (std::size_t i = 0; i < logged.volume_m3.size(); ++i) {
      logged.volume_m3[i] = motion.at(0.01 / 4.0 * static_cast<double>(i) - delay_s).volume_m3;
    }
    const std::vector<double> expected = run(0, nominal(), actual, 3e5);
    const std::vector<double> late = run(0, nominal(), logged, 3e5);
    const std::vector<double> undone = run(
        only(kIdVolumeError), with(nominal(), kIdVolumeError, {0.0, 0.0, 0.0, 0.0, delay_s}), logged, 3e5);
    const std::size_t known = expected.size() - 10;  // the log ends before what it says of its last rows
    double late_squares = 0.0, undone_squares = 0.0;
    for (std::size_t k = 0; k < known; ++k) {
      late_squares += std::pow(late[k] - expected[k], 2);
      undone_squares += std::pow(undone[k] - expected[k], 2);
    }
    EXPECT_GT(std::sqrt(late_squares / static_cast<double>(known)), 3e3) << "Pa";
    EXPECT_LT(std::sqrt(undone_squares / late_squares), 2e-3) << delay_s << " s";
  }
}

TEST(VolumeError, GoesOnAsTheLogLastMovedBeyondItsEnd) {
  // a volume that grows evenly is known at any time
  const double logged_m3[] = {200e-6, 202e-6, 204e-6};
  const double figures[] = {0.0, 0.0, 0.0, 0.0, 0.0333};
  VolumeError<double> error;
  error.prepare(figures, 200e-6);
  const VolumeError<double>::Motion motion = error.step(logged_m3, 0.01);
  EXPECT_NEAR(motion.volume_m3, 201e-6 + 2e-6 * 3.33, 1e-15);
  EXPECT_NEAR(motion.rate_m3_s, 200e-6, 1e-12);
}

TEST(VolumeError, LeavesATenthOfTheLoggedVolume) {
  const double logged_m3[] = {200e-6, 220e-6};
  const double figures[] = {-5000.0, 0.0, 0.0, 0.0, 0.0};
  VolumeError<double> error;
  error.prepare(figures, 200e-6);
  EXPECT_DOUBLE_EQ(error.volume(200e-6), 20e-6);
  const VolumeError<double>::Motion least = error.step(logged_m3, 0.01);
  EXPECT_DOUBLE_EQ(least.volume_m3, 21e-6);
  EXPECT_DOUBLE_EQ(least.rate_m3_s, 0.1 * 20e-6 / 0.01);
  // a log that falls would fall below nothing before it is told
  const double falling_m3[] = {200e-6, 160e-6}, late[] = {0.0, 0.0, 0.0, 0.0, 0.1};
  error.prepare(late, 200e-6);
  EXPECT_DOUBLE_EQ(error.step(falling_m3, 0.01).volume_m3, 18e-6);
}

}  // namespace
}  // namespace plenum::host::effects
