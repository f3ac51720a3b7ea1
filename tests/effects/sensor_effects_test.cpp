// sensor_lag and sensor_bias.
#include <gtest/gtest.h>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

SensorLag<double> sensor_of(double time_constant_s, double step_s, double start_Pa) {
  SensorLag<double> sensor;
  sensor.prepare(&time_constant_s, step_s, start_Pa);
  return sensor;
}

TEST(SensorLag, RampIsReadLateByTheTimeConstant) {
  for (const double step_s : {0.0005, 0.01}) {
    SensorLag<double> sensor = sensor_of(0.02, step_s, 1e5);
    const double rate_Pa_s = 3e5;
    double p = 1e5;
    for (int k = 0; k < 2000; ++k) {
      const double next = p + rate_Pa_s * step_s;
      const double mean = sensor.follow(p, next, 0.5 * (p + next));
      p = next;
      const double gone = 1.0 - std::exp(-(k + 1) * step_s / 0.02);
      ASSERT_NEAR(sensor.reading_Pa(), p - rate_Pa_s * 0.02 * gone, 1e-6 * p) << "Pa";
      if (k > 1000) {
        ASSERT_NEAR(mean, p - 0.5 * rate_Pa_s * step_s - rate_Pa_s * 0.02, 1e-6 * p) << "Pa";
      }
    }
  }
}

TEST(SensorLag, StepIsReadAsAnExponential) {
  SensorLag<double> sensor = sensor_of(0.015, 0.0025, 1e5);
  for (int k = 1; k < 40; ++k) {
    sensor.follow(2e5, 2e5, 2e5);
    ASSERT_NEAR(sensor.reading_Pa(), 2e5 - 1e5 * std::exp(-0.0025 * k / 0.015), 1e-6) << "Pa";
  }
}

TEST(SensorLag, MeanReadingKeepsTheBalanceOfItsEquation) {
  // tau (y_1 - y_0) = int (p - y), whatever the pressure does
  const double tau_s = 0.008;
  SensorLag<double> sensor = sensor_of(tau_s, 0.0025, 3e5);
  double before = 3e5;
  double integral = 0.0;
  double p = 3e5;
  std::mt19937 bits(3);
  for (int k = 0; k < 1000; ++k) {
    const double next = 1e5 + 6e5 * static_cast<double>(bits()) / 4294967296.0;
    const double mean = 0.5 * (p + next) + 1e3;
    integral += 0.0025 * (mean - sensor.follow(p, next, mean));
    p = next;
  }
  EXPECT_NEAR(tau_s * (sensor.reading_Pa() - before), integral, 1e-6) << "Pa s";
}

TEST(SensorLag, WithoutTimeConstantTheReadingIsThePressure) {
  SensorLag<double> sensor = sensor_of(0.0, 0.0025, 1e5);
  EXPECT_EQ(sensor.follow(1e5, 2e5, 1.4e5), 1.4e5);
  EXPECT_EQ(sensor.reading_Pa(), 2e5);
}

TEST(SensorLag, DoesNotTouchTheChamber) {
  const Drive drive = drive_of(jumping_command_V(300), swinging_volume(), 4);
  const Figures figures = with(with(nominal(), kIdSensorLag, {0.05}), kIdSensorBias, {20.0, 0.1});
  ChamberModel<double> plain({}, drive.timing, 0, figures.data(), 3e5, drive.command_V[0],
                             drive.volume_m3[0]);
  ChamberModel<double> read({}, drive.timing, only(kIdSensorLag) | only(kIdSensorBias), figures.data(), 3e5,
                            drive.command_V[0], drive.volume_m3[0]);
  for (std::size_t k = 0; k + 1 < drive.command_V.size(); ++k) {
    plain.tick(drive.command_V[k], drive.volume_m3.data() + 4 * k);
    read.tick(drive.command_V[k], drive.volume_m3.data() + 4 * k);
    ASSERT_EQ(plain.pressure_Pa(), read.pressure_Pa()) << "Pa, tick " << k;
  }
}

TEST(SensorBias, ReadingIsOffByItsOffsetAndByItsGainAboveAmbient) {
  const Drive drive = drive_of(jumping_command_V(300), swinging_volume(), 4);
  const std::vector<double> plain = run(0, nominal(), drive, 3e5);
  const std::vector<double> biased =
      run(only(kIdSensorBias), with(nominal(), kIdSensorBias, {-3.0, 0.02}), drive, 3e5);
  for (std::size_t k = 1; k < plain.size(); ++k) {
    ASSERT_NEAR(biased[k], plain[k] - 3000.0 + 0.02 * (plain[k] - 101325.0), 1e-9) << "Pa, row " << k;
  }
}

TEST(SensorAverage, IsOverTheLastStepsOfATick) {
  // a pressure that rises linearly: choked fill of a large chamber
  const Figures figures = sharp_valve(1e-6);
  const std::vector<double> volume_m3(5, 1.0);
  const auto late_s = [&](double average_s) {
    ChamberModel<double> model({}, {.tick_s = kTick_s, .average_s = average_s, .steps = 4}, 0, figures.data(),
                               1.5e5, 7.0, 1.0);
    const double before = model.pressure_Pa();
    const double reading = model.tick(7.0, volume_m3.data());
    const double rate_Pa_s = (model.pressure_Pa() - before) / kTick_s;
    return (model.pressure_Pa() - reading) / rate_Pa_s;
  };
  EXPECT_NEAR(late_s(0.0), 0.0, 1e-12);
  EXPECT_NEAR(late_s(0.0025), 0.00125, 1e-6);
  EXPECT_NEAR(late_s(0.005), 0.0025, 1e-6);
  EXPECT_NEAR(late_s(0.01), 0.005, 1e-6);
}

}  // namespace
}  // namespace plenum::host::effects
