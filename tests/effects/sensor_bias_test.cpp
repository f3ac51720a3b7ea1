// sensor_bias: what it adds to a reading.
#include <gtest/gtest.h>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

TEST(SensorBias, ReadingDriftsWithItsTimeConstantOrAsARampAndFollowsTheCommandsGround) {
  std::vector<double> command_V = jumping_command_V(3000);
  const Drive drive = drive_of(command_V, swinging_volume(), 4);
  const std::vector<double> plain_Pa = run(0, nominal(), drive, 3e5);
  const double null_V = 0.5 * (nominal()[kOpenAbove] + nominal()[kExhaustBelow]);
  for (const double tau_s : {7.0, kInfinity}) {
    Figures figures = nominal();
    double* const x = figures.data() + kFirstFigure[kIdSensorBias];
    x[2] = 12.0;
    x[3] = 1.0 / tau_s;
    x[4] = -0.8;
    x[5] = 0.5;
    const std::vector<double> biased_Pa = run(only(kIdSensorBias), figures, drive, 3e5);
    for (std::size_t row = 1; row < plain_Pa.size(); ++row) {
      const double time_s = kTick_s * static_cast<double>(row);
      const double drift =
          std::isinf(tau_s) ? time_s / 60.0 : std::expm1(-time_s / tau_s) / std::expm1(-60.0 / tau_s);
      ASSERT_NEAR(biased_Pa[row] - plain_Pa[row],
                  12e3 * drift - 0.8e3 * (command_V[row - 1] - null_V) +
                      0.5e3 * std::abs(command_V[row - 1] - null_V),
                  1e-4)
          << "Pa, row " << row;
    }
  }
}

TEST(SensorBias, BentReadingIsOffAParabolaThroughAmbientAndSupply) {
  const Drive drive = drive_of(jumping_command_V(300), swinging_volume(), 4);
  const std::vector<double> plain = run(0, nominal(), drive, 3e5);
  Figures figures = nominal();
  figures[kFirstFigure[kIdSensorBias] + 6] = -0.01;
  const std::vector<double> bent = run(only(kIdSensorBias), figures, drive, 3e5);
  const double span_Pa = kSupply_Pa - kAmbient_Pa;
  for (std::size_t k = 1; k < plain.size(); ++k) {
    const double share = (plain[k] - kAmbient_Pa) / span_Pa;
    ASSERT_NEAR(bent[k], plain[k] - 0.01 * span_Pa * (1.0 - std::pow(2.0 * share - 1.0, 2)), 1e-6)
        << "Pa, row " << k;
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

}  // namespace
}  // namespace plenum::host::effects
