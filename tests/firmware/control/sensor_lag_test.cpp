// A lagging sensor: closed forms, and the observer's gain against the least spread that any gain reaches.
#include "firmware/control/sensor_lag.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

TEST(SensorLag, APromptSensorShowsThePressure) {
  SensorLag sensor;
  sensor.configure(0, 2);
  sensor.reset(100);
  EXPECT_FALSE(sensor.lags());
  EXPECT_EQ(sensor.pass(100, {.end_kPa = 120, .mean_kPa = 111}), 111);
  EXPECT_EQ(sensor.observe(120, {.end_kPa = 130, .mean_kPa = 125}, 128).missed_kPa, 3) << "against the mean";
}

TEST(SensorLag, ShowsAnEvenRiseAsTheClosedFormHasIt) {
  // y = r (t - tau (1 - e^(-t/tau))) behind p = r t: its mean over [0, T] is r (T/2 - tau + tau^2 (1 - e^(-T/tau))/T)
  constexpr double kTau = 3, kRise = 10;
  SensorLag sensor;
  sensor.configure(static_cast<float>(kTau), 2);
  sensor.reset(0);
  double sum = 0;
  for (int k = 1; k <= 12; ++k) {
    const auto from = static_cast<float>(kRise * (k - 1));
    sum += static_cast<double>(sensor.pass(from, {.end_kPa = from + 10, .mean_kPa = from + 5}));
    const double mean = kRise * (k / 2.0 - kTau + kTau * kTau * (1 - std::exp(-k / kTau)) / k);
    EXPECT_NEAR(sum / k, mean, 1e-4) << "kPa, mean of " << k << " ticks";
  }
}

TEST(SensorLag, ShowsABendAsTheDifferentialEquationHasIt) {
  // p = 40 t (1 - t) on the way from 0 to 0: only its mean tells
  for (const double tau : {0.3, 1.0, 4.0, 20.0}) {
    SensorLag sensor;
    sensor.configure(static_cast<float>(tau), 2);
    sensor.reset(0);
    const auto first = static_cast<double>(sensor.pass(0, {.end_kPa = 0, .mean_kPa = 40.0F / 6}));
    const auto second = static_cast<double>(sensor.pass(0, {.end_kPa = 0, .mean_kPa = 0}));
    constexpr int kSteps = 100'000;
    double y = 0, sum_first = 0, sum_second = 0;
    for (int i = 0; i < 2 * kSteps; ++i) {
      const double t = (i + 0.5) / kSteps;
      const double p = t < 1 ? 40 * t * (1 - t) : 0;
      const double next = p + (y - p) * std::exp(-1.0 / (tau * kSteps));
      (t < 1 ? sum_first : sum_second) += 0.5 * (y + next) / kSteps;
      y = next;
    }
    EXPECT_NEAR(first, sum_first, 2e-4) << "tau " << tau;
    EXPECT_NEAR(second, sum_second, 2e-4) << "tau " << tau;
  }
}

/// RMS error of the pressure's estimate while a random walk moves it, with the observer's answer scaled.
double rms_with(double scale) {
  constexpr float kTau = 4;
  constexpr double kModel_kPa = 2;
  std::mt19937 random(7);
  std::normal_distribution<double> move(0, kModel_kPa),
      noise(0, static_cast<double>(SensorLag::kReadingNoise_kPa));
  SensorLag truth, sensor;
  truth.configure(kTau, static_cast<float>(kModel_kPa));
  sensor.configure(kTau, static_cast<float>(kModel_kPa));
  Scalar pressure = 300, estimate = 300;
  truth.reset(300);
  sensor.reset(300);
  double square = 0;
  constexpr int kTicks = 20'000;
  for (int k = 0; k < kTicks; ++k) {
    const Scalar next = pressure + static_cast<float>(move(random));
    const Scalar mean = 0.5F * (pressure + next);
    const Scalar reading =
        truth.pass(pressure, {.end_kPa = next, .mean_kPa = mean}) + static_cast<float>(noise(random));
    pressure = next;
    estimate += static_cast<float>(scale) *
                sensor.observe(estimate, {.end_kPa = estimate, .mean_kPa = estimate}, reading).above_kPa;
    const auto off = static_cast<double>(estimate - pressure);
    square += off * off / kTicks;
  }
  return std::sqrt(square);
}

TEST(SensorLag, ItsGainIsTheOneOfLeastSpread) {
  const double best = rms_with(1);
  EXPECT_LT(best, rms_with(0.85));
  EXPECT_LT(best, rms_with(1.15));
  // a filter that knows nothing of the lag would carry it whole: 2 kPa a tick over 4 ticks
  EXPECT_LT(best, 2.5) << "kPa, where one move has 2";
}

}  // namespace
}  // namespace plenum::control
