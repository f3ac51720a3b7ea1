// spool_lag: what it makes of the command, against closed forms and the plant.
#include <gtest/gtest.h>

#include <numbers>

#include "host-sim/plant/chamber.hpp"
#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

constexpr double kNull_V = 5.0;

SpoolLag<double> spool_of(double frequency_Hz, double damping, double step_s) {
  const double x[] = {1.0 / frequency_Hz, damping, 0.0, 0.0, 0.0, 0.0, 2.0};
  SpoolLag<double> spool;
  spool.prepare(x, step_s, 0.0, kNull_V);
  return spool;
}

TEST(SpoolLag, StepResponseMatchesTheClosedFormAtAnyStep) {
  for (const double damping : {0.4, 0.8, 1.0, 1.7, 10.0}) {
    for (const double step_s : {0.0001, 0.0025, 0.01, 0.02}) {
      SpoolLag<double> spool = spool_of(12.0, damping, step_s);
      // where the poles meet they are moved apart by 1e-4
      const double within = damping == 1.0 ? 1e-4 : 1e-9;
      const double w = 2.0 * std::numbers::pi * 12.0;
      for (int k = 0; k * step_s < 0.2; ++k) {
        ASSERT_NEAR(spool.follow(1.0), mean_step_response(w * k * step_s, w * step_s, damping), within)
            << "V, damping " << damping << " step " << step_s << " s, number " << k;
      }
    }
  }
}

TEST(SpoolLag, InfinitelyFastSpoolIsWhereItsCommandIs) {
  SpoolLag<double> spool = spool_of(kInfinity, 0.8, 0.0025);
  for (const double u : {5.0, 7.3, 2.0, 2.0, 9.9}) EXPECT_EQ(spool.follow(u), u);
}

TEST(SpoolLag, SpoolFasterThanTheStepIsLateByTwiceItsDampingOverItsFrequency) {
  for (const double frequency_Hz : {400.0, 2000.0, 1e5}) {
    SpoolLag<double> spool = spool_of(frequency_Hz, 0.6, 0.01);
    const double late_s = 2.0 * 0.6 / (2.0 * std::numbers::pi * frequency_Hz);
    double area_s = 0.0;
    for (int k = 0; k < 10; ++k) area_s += 0.01 * (1.0 - spool.follow(1.0));
    EXPECT_NEAR(area_s / late_s, 1.0, 1e-6) << frequency_Hz << " Hz";
  }
}

// x' = r asks for v = r/(1 - (r/S)^n)^(1/n), and v for c - x = 2 zeta v/w.
void expect_as_late_on_a_ramp_as_its_speed_takes(double sharpness) {
  const double step_s = 1e-4, damping = 0.7, slew_V_s = 40.0, frequency_Hz = 20.0;
  const double omega_1_s = 2.0 * std::numbers::pi * frequency_Hz;
  for (const double rate_V_s : {5.0, 20.0, 36.0}) {
    const double x[] = {1.0 / frequency_Hz, damping, 1.0 / (slew_V_s * slew_V_s), 0.0, 0.0, 0.0, sharpness};
    SpoolLag<double> spool;
    spool.prepare(x, step_s, 0.0, kNull_V);
    double late_V = 0.0;
    for (int k = 0; k < 100000; ++k) {
      const double command_V = rate_V_s * step_s * (k + 0.5);
      late_V = command_V - spool.follow(command_V);
    }
    const double share = std::pow(rate_V_s / slew_V_s, sharpness);
    const double expected_V = 2.0 * damping / omega_1_s * rate_V_s / std::pow(1.0 - share, 1.0 / sharpness);
    EXPECT_NEAR(late_V / expected_V, 1.0, 1e-3) << rate_V_s << " V/s, sharpness " << sharpness;
  }
}

TEST(SpoolLag, SpoolOfLimitedSpeedFollowsARampAsLateAsTheForceForItsSpeedTakes) {
  expect_as_late_on_a_ramp_as_its_speed_takes(2.0);
}

TEST(SpoolLag, ASharperLimitIsNotNoticedUntilItIsNear) {
  for (const double sharpness : {1.0, 4.0, 12.0}) expect_as_late_on_a_ramp_as_its_speed_takes(sharpness);
}

TEST(SpoolLag, SharpnessOfTwoIsTheRootThatIsCalculatedForIt) {
  const double x[] = {0.05, 0.7, 1.0 / 900.0, 0.0, 0.0, 0.0, 2.0},
               beside[] = {0.05, 0.7, 1.0 / 900.0, 0.0, 0.0, 0.0, 2.0 + 1e-9};
  SpoolLag<double> root, power;
  root.prepare(x, 0.001, kNull_V, kNull_V);
  power.prepare(beside, 0.001, kNull_V, kNull_V);
  for (int k = 0; k < 400; ++k) {
    const double command_V = kNull_V + (k % 100 < 50 ? 3.0 : -0.01);
    ASSERT_NEAR(root.follow(command_V), power.follow(command_V), 1e-5) << "V, step " << k;
  }
}

TEST(SpoolLag, NoSpoolIsFasterThanItsSlew) {
  for (const double frequency_Hz : {10.0, 100.0, 1e4, kInfinity}) {
    const double slew_V_s = 30.0, step_s = 0.001;
    const double x[] = {1.0 / frequency_Hz, 0.5, 1.0 / (slew_V_s * slew_V_s), 0.0, 0.0, 0.0, 2.0};
    SpoolLag<double> spool;
    spool.prepare(x, step_s, 0.0, kNull_V);
    for (int k = 0; k < 100; ++k) {
      ASSERT_LE(spool.follow(5.0), slew_V_s * step_s * (k + 1))
          << "V after step " << k << ", " << frequency_Hz << " Hz";
    }
    for (int k = 0; k < 900; ++k) spool.follow(5.0);
    EXPECT_NEAR(spool.follow(5.0), 5.0, 1e-3) << "V, " << frequency_Hz << " Hz: it arrives";
  }
}

TEST(SpoolLag, CoilBeforeAFastSpoolIsAFirstOrderLag) {
  const double step_s = 0.002, coil_s = 0.006;
  const double x[] = {0.0, 0.8, 0.0, coil_s, 0.0, 0.0, 2.0};
  SpoolLag<double> spool;
  spool.prepare(x, step_s, 0.0, kNull_V);
  for (int k = 0; k < 30; ++k) {
    const double begin = std::exp(-k * step_s / coil_s), end = std::exp(-(k + 1) * step_s / coil_s);
    ASSERT_NEAR(spool.follow(1.0), 1.0 - coil_s / step_s * (begin - end), 1e-12) << "V, step " << k;
  }
}

TEST(SpoolLag, CoilThatFallsFasterThanItRisesIsADifferentLagEachWay) {
  const double step_s = 0.002, coil_s = 0.006, rise = 0.5;
  const double x[] = {0.0, 0.8, 0.0, coil_s, rise, 0.0, 2.0};
  SpoolLag<double> spool;
  spool.prepare(x, step_s, 0.0, kNull_V);
  for (int k = 0; k < 400; ++k) {
    const double tau_s = coil_s * (1.0 + rise), begin = std::exp(-k * step_s / tau_s);
    ASSERT_NEAR(spool.follow(1.0), 1.0 - tau_s / step_s * begin * (1.0 - std::exp(-step_s / tau_s)), 1e-12)
        << "V up, step " << k;
  }
  for (int k = 0; k < 20; ++k) {
    const double tau_s = coil_s * (1.0 - rise), begin = std::exp(-k * step_s / tau_s);
    ASSERT_NEAR(spool.follow(0.0), tau_s / step_s * begin * (1.0 - std::exp(-step_s / tau_s)), 1e-12)
        << "V down, step " << k;
  }
}

TEST(SpoolLag, CoilThatComesBackMoreSlowlyThanItLeavesIsADifferentLagOnEitherSideOfTheNull) {
  const double step_s = 0.002, coil_s = 0.006, back = 0.3;
  const double x[] = {0.0, 0.8, 0.0, coil_s, 0.0, back, 2.0};
  for (const double side : {1.0, -1.0}) {
    SpoolLag<double> spool;
    spool.prepare(x, step_s, kNull_V, kNull_V);
    const auto mean_of = [&](double tau_s, int k) {
      return tau_s / step_s * std::exp(-k * step_s / tau_s) * (1.0 - std::exp(-step_s / tau_s));
    };
    for (int k = 0; k < 400; ++k) {
      ASSERT_NEAR(side * (spool.follow(kNull_V + side) - kNull_V), 1.0 - mean_of(coil_s * (1.0 - back), k),
                  1e-12)
          << "V away, step " << k << ", side " << side;
    }
    for (int k = 0; k < 20; ++k) {
      ASSERT_NEAR(side * (spool.follow(kNull_V) - kNull_V), mean_of(coil_s * (1.0 + back), k), 1e-12)
          << "V back, step " << k << ", side " << side;
    }
  }
}

TEST(SpoolLag, ChamberAgreesWithThePlantThatHasTheSameSpool) {
  const std::vector<double> command_V = jumping_command_V(1500);
  for (const double frequency_Hz : {10.0, 65.0, 125.0}) {
    plant::ChamberConfig config;
    config.initial_pressure_Pa = 3e5;
    config.initial_command_V = command_V.front();
    config.spool = plant::SpoolConfig{.natural_frequency_Hz = frequency_Hz, .damping_ratio = 0.7};
    config.tolerance_Pa = 0.02;
    plant::ChamberPlant plant(plant::ThinPlateValve({}), config, swinging_volume());
    std::vector<double> truth_Pa{3e5};
    for (std::size_t k = 0; k + 1 < command_V.size(); ++k) {
      truth_Pa.push_back(plant.advance(command_V[k], kTick_s).mean_Pa);
    }
    const Figures figures = with(nominal(), kIdSpoolLag, {frequency_Hz, 0.7});
    const auto error_Pa = [&](int steps) {
      return rms_difference(
          run(only(kIdSpoolLag), figures, drive_of(command_V, swinging_volume(), steps), 3e5), truth_Pa);
    };
    EXPECT_LT(error_Pa(4), 50.0) << "Pa RMS at " << frequency_Hz << " Hz";
    EXPECT_LT(error_Pa(16), 4.0) << "Pa RMS at " << frequency_Hz << " Hz";
  }
}

}  // namespace
}  // namespace plenum::host::effects
