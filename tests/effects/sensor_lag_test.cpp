// sensor_lag against closed forms.
#include <gtest/gtest.h>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

SensorLag<double> sensor_of(double time_constant_s, double step_s, double start_Pa,
                            double damping = kInfinity) {
  const double x[] = {time_constant_s, 1.0 / (damping * damping)};
  SensorLag<double> sensor;
  sensor.prepare(x, step_s, start_Pa);
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

TEST(SensorLag, StepIsReadAsByADampedMass) {
  for (const double damping : {0.5, 0.7, 1.0, 1.5, 30.0}) {
    for (const double step_s : {0.0005, 0.0025, 0.02}) {
      SensorLag<double> sensor = sensor_of(0.015, step_s, 1e5, damping);
      const double w = 2.0 * damping / 0.015;
      for (int k = 1; k * step_s < 0.2; ++k) {
        const double mean = sensor.follow(2e5, 2e5, 2e5);
        ASSERT_NEAR(sensor.reading_Pa(), 1e5 + 1e5 * step_response(w * k * step_s, damping), 1e-3)
            << "Pa, damping " << damping << " step " << step_s << " s, number " << k;
        ASSERT_NEAR(mean, 1e5 + 1e5 * mean_step_response(w * (k - 1) * step_s, w * step_s, damping), 1.0)
            << "Pa, damping " << damping << " step " << step_s << " s, number " << k;
      }
    }
  }
}

TEST(SensorLag, RampIsReadLateByTheTimeConstantWhateverTheDamping) {
  for (const double damping : {0.5, 1.0, 3.0}) {
    SensorLag<double> sensor = sensor_of(0.02, 0.0025, 1e5, damping);
    double p = 1e5;
    double mean = 0.0;
    for (int k = 0; k < 400; ++k, p += 1e3) mean = sensor.follow(p, p + 1e3, p + 500.0);
    EXPECT_NEAR(p - sensor.reading_Pa(), 4e5 * 0.02, 1e-5) << "Pa, damping " << damping;
    EXPECT_NEAR(p - 500.0 - mean, 4e5 * 0.02, 1e-5) << "Pa, damping " << damping;
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
    plain.tick(drive.command_V[k], std::span(drive.volume_m3).subspan(4 * k));
    read.tick(drive.command_V[k], std::span(drive.volume_m3).subspan(4 * k));
    ASSERT_EQ(plain.pressure_Pa(), read.pressure_Pa()) << "Pa, tick " << k;
  }
}

}  // namespace
}  // namespace plenum::host::effects
