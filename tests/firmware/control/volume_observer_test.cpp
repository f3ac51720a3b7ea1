// The volume observer against motions whose rate is known.
#include "firmware/control/volume_observer.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "firmware/config/chamber_settings.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

constexpr double kTick_s = 0.01;

VolumeObserver observer_at(float volume_mL, VolumeObserver::Config config = {}) {
  VolumeObserver observer;
  observer.configure(config);
  observer.reset(volume_mL);
  return observer;
}

TEST(VolumeObserver, HoldsAVolumeAtRest) {
  VolumeObserver observer = observer_at(250.0F);
  for (int i = 0; i < 100; ++i) {
    const ChamberMotion motion = observer.step(250.0F);
    EXPECT_NEAR(real(motion.volume_mL), 250.0F, 1e-3F);
    EXPECT_NEAR(real(motion.volume_rate_mL_s), 0.0F, 1e-2F);
  }
}

TEST(VolumeObserver, FollowsConstantAccelerationWithoutError) {
  VolumeObserver observer = observer_at(100.0F);
  ChamberMotion motion;
  double end = 0;
  for (int i = 0; i < 300; ++i) {
    const double middle = (i + 0.5) * kTick_s;  // a mean over tick i belongs to its middle
    motion = observer.step(static_cast<float>(100 + 20 * middle + 0.5 * 40 * middle * middle));
    end = middle + kTick_s;  // and the answer to the middle of the tick after it
  }
  EXPECT_NEAR(real(motion.volume_mL), 100 + 20 * end + 20 * end * end, 2e-3);
  EXPECT_NEAR(real(motion.volume_rate_mL_s), 20 + 40 * end, 0.2);
}

TEST(VolumeObserver, GoesOnAsItMovedWhereNothingIsMeasured) {
  VolumeObserver observer = observer_at(100.0F);
  const auto volume_mL = [](double t) { return 100 + 20 * t + 0.5 * 40 * t * t; };
  for (int i = 0; i < 300; ++i) observer.step(static_cast<float>(volume_mL((i + 0.5) * kTick_s)));
  for (int i = 300; i < 305; ++i) {
    const ChamberMotion next = observer.coast();
    const double middle = (i + 0.5) * kTick_s;
    EXPECT_NEAR(real(observer.past().volume_mL), volume_mL(middle), 5e-3);
    EXPECT_NEAR(real(next.volume_mL), volume_mL(middle + kTick_s), 5e-3);
    EXPECT_NEAR(real(next.volume_rate_mL_s), 20 + 40 * (middle + kTick_s), 0.2);
  }
}

VolumeObserver::Config config_of(double noise_mL, double jerk_mL_s3) {
  config::ChamberSettings settings;
  settings.volume_noise_mL = static_cast<float>(noise_mL);
  settings.volume_jerk_mL_per_s3 = static_cast<float>(jerk_mL_s3);
  EXPECT_TRUE(config::validate(settings));
  return {.tracking_index = config::tracking_index(settings)};
}

/// The filter's gains from the unscaled Riccati equation in double, by so many steps that it stands still.
Eigen::Vector3d steady_gains(double noise_mL, double jerk_mL_s3) {
  Eigen::Matrix3d transition;
  transition << 1, 1, 0.5, 0, 1, 1, 0, 0, 1;
  const double jerk_mL = jerk_mL_s3 * kTick_s * kTick_s * kTick_s, noise = noise_mL * noise_mL;
  const Eigen::Vector3d push(jerk_mL / 6, jerk_mL / 2, jerk_mL);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity() * noise;
  Eigen::Vector3d gain;
  for (int i = 0; i < 20'000; ++i) {
    covariance = transition * covariance * transition.transpose() + push * push.transpose();
    gain = covariance.col(0) / (covariance(0, 0) + noise);
    const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - gain * Eigen::RowVector3d::UnitX();
    covariance = left * covariance * left.transpose() + noise * gain * gain.transpose();
  }
  return gain;
}

// Of sensors and loads as far apart as the settings let them be: what is not between the bounds of the index is at one of them.
TEST(VolumeObserver, AnswersAStepAsTheSteadyFilterOfItsNoiseAndItsLoadDoes) {
  for (const auto& [noise_mL, jerk_mL_s3] :
       {std::pair{100.0, 1e4}, {1.0, 200.0}, {0.5, 12'000.0}, {0.05, 30'000.0}, {0.01, 1e5}, {0.001, 6e4}}) {
    const Eigen::Vector3d gain = steady_gains(noise_mL, jerk_mL_s3);
    Eigen::Vector3d state(100, 0, 0);
    VolumeObserver observer = observer_at(100.0F, config_of(noise_mL, jerk_mL_s3));
    for (int i = 0; i < 200; ++i) {
      state = Eigen::Vector3d(state[0] + state[1] + state[2] / 2, state[1] + state[2], state[2]);
      state += gain * (110 - state[0]);
      observer.step(110.0F);
      EXPECT_NEAR(real(observer.past().volume_mL), state[0], 0.1)
          << "mL, tick " << i << ", noise " << noise_mL << " mL, jerk " << jerk_mL_s3 << " mL/s^3";
      EXPECT_NEAR(real(observer.past().volume_rate_mL_s) * kTick_s, state[1], 0.1) << "mL a tick, tick " << i;
    }
  }
}

TEST(VolumeObserver, SettlesWhateverNoiseAndLoadTheSettingsAdmit) {
  for (const double noise_mL : {0.001, 0.05, 1.0, 100.0}) {
    for (const double jerk_mL_s3 : {1.0, 1e3, 1e5, 1e8}) {
      VolumeObserver observer = observer_at(100.0F, config_of(noise_mL, jerk_mL_s3));
      for (int i = 0; i < 600; ++i) observer.step(110.0F);
      EXPECT_NEAR(real(observer.past().volume_mL), 110.0, 0.05)
          << "mL, noise " << noise_mL << " mL, jerk " << jerk_mL_s3 << " mL/s^3";
    }
  }
}

// 100 mL swinging by a third at 1.5 Hz, noise of a good potentiometer: the rate of the tick to come.
TEST(VolumeObserver, BeatsTheBareDifferenceOnANoisySine) {
  const double omega = 2 * std::numbers::pi * 1.5;
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 0.05);
  VolumeObserver observer = observer_at(100.0F);
  double observer_square = 0;
  double difference_square = 0;
  double last = 100;
  int counted = 0;
  for (int i = 0; i < 2'000; ++i) {
    const double middle = (i + 0.5) * kTick_s;
    const double measured = 100 + 33 * std::sin(omega * middle) + noise(random);
    const ChamberMotion motion = observer.step(static_cast<float>(measured));
    const double truth = 33 * omega * std::cos(omega * (middle + kTick_s));
    if (i > 50) {
      observer_square += std::pow(static_cast<double>(motion.volume_rate_mL_s) - truth, 2);
      difference_square += std::pow((measured - last) / kTick_s - truth, 2);
      ++counted;
    }
    last = measured;
  }
  const double observer_rms = std::sqrt(observer_square / counted);
  const double difference_rms = std::sqrt(difference_square / counted);
  EXPECT_LT(observer_rms, 0.5 * difference_rms)
      << "rate error [mL/s]: observer " << observer_rms << ", bare difference " << difference_rms;
}

}  // namespace
}  // namespace plenum::control
