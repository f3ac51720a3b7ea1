// heat_transfer against closed forms and balances.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

Drive instants(const std::vector<double>& command_V, const plant::VolumeMotion& volume, int steps) {
  Drive drive = drive_of(command_V, volume, steps);
  drive.timing.average_s = 0.0;
  return drive;
}

/// Largest relative departure of p v^n from its start, in a sealed chamber that is squeezed.
double departure(const Figures& figures, double exponent, int steps = 16) {
  const Drive drive = instants(std::vector<double>(400, 5.0), swinging_volume(), steps);
  const std::vector<double> p = run(only(kIdHeatTransfer), figures, drive, 3e5);
  double worst = 0.0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const double v = drive.volume_m3[k * static_cast<std::size_t>(steps)] / drive.volume_m3[0];
    worst = std::max(worst, std::abs(p[k] * std::pow(v, exponent) / 3e5 - 1.0));
  }
  return worst;
}

TEST(HeatTransfer, WithoutConductanceASqueezeIsAdiabatic) {
  EXPECT_LT(departure(with(sealed(), kIdHeatTransfer, {0.0, 1.4}), 1.4), 1e-6);
}

TEST(HeatTransfer, ExponentIsThatOfASqueezeWithoutConductance) {
  EXPECT_LT(departure(with(sealed(), kIdHeatTransfer, {0.0, 1.2}), 1.2), 1e-6);
  EXPECT_LT(departure(with(sealed(), kIdHeatTransfer, {0.0, 1.0}), 1.0), 1e-6);
}

TEST(HeatTransfer, GreatConductanceMakesASqueezeIsothermal) {
  // the pressure is then in equilibrium with the volume of the step's middle: first order
  EXPECT_LT(departure(with(sealed(), kIdHeatTransfer, {1e7, 1.4}), 1.0, 16), 1e-3);
  EXPECT_LT(departure(with(sealed(), kIdHeatTransfer, {1e7, 1.4}), 1.0, 256), 1e-3 / 16.0);
}

TEST(HeatTransfer, GreatConductanceHoldsThePerfectGasAtWallTemperatureThroughFillsAndDumps) {
  // an isothermal chamber is that of exponent 1: neither balance of mass can drift from the other
  const Drive drive = instants(jumping_command_V(500), swinging_volume(), 1024);
  const std::vector<double> conducting =
      run(only(kIdHeatTransfer), with(nominal(), kIdHeatTransfer, {1e6, 1.4}), drive, 3e5);
  const std::vector<double> isothermal =
      run(only(kIdHeatTransfer), with(nominal(), kIdHeatTransfer, {0.0, 1.0}), drive, 3e5);
  EXPECT_LT(rms_difference(conducting, isothermal), 5.0) << "Pa";
}

TEST(HeatTransfer, AWallThatHardlyConductsChangesNothingHoweverLongFillsAndDumpsGoOn) {
  // each of them leaves mass and energy a little further apart
  const Drive drive = drive_of(jumping_command_V(20000), swinging_volume(), 4);
  const std::vector<double> none =
      run(only(kIdHeatTransfer), with(nominal(), kIdHeatTransfer, {0.0, 1.4}), drive, 3e5);
  const std::vector<double> hardly =
      run(only(kIdHeatTransfer), with(nominal(), kIdHeatTransfer, {1e-6, 1.4}), drive, 3e5);
  EXPECT_LT(rms_difference(hardly, none), 10.0) << "Pa";
}

TEST(HeatTransfer, PressureAfterAFastSqueezeFadesWithTheGassOwnTimeConstant) {
  // squeezed to 0.8 of the volume within a tick, then held: p settles at p_0/0.8
  const double conductance_W_K = 0.2;
  const Figures figures = with(sealed(), kIdHeatTransfer, {conductance_W_K, 1.4, 0.0, 20.0});
  const Timing timing{.tick_s = kTick_s, .average_s = 0.0, .steps = 64};
  ChamberModel<double> model({}, timing, only(kIdHeatTransfer), figures.data(), 3e5, 5.0, 200e-6);
  std::vector<double> squeeze;
  for (int i = 0; i <= 64; ++i) squeeze.push_back(200e-6 * (1.0 - 0.2 * i / 64.0));
  model.tick(5.0, squeeze);
  const std::vector<double> hold(65, squeeze.back());
  const double mass_kg = 3e5 * 200e-6 / RT();
  const double c_v = Surroundings{}.gas.specific_gas_constant_J_kg_K() / 0.4;
  const double tau_s =
      c_v * mass_kg / (conductance_W_K * (160.0 + 20.0) / 100.0);  // of the 160 mL and its ends
  const double first_Pa = model.pressure_Pa() - 3e5 / 0.8;
  EXPECT_GT(first_Pa, 2e4) << "Pa: heated by the squeeze";
  for (int k = 1; k <= 300; ++k) {
    model.tick(5.0, hold);
    ASSERT_NEAR(model.pressure_Pa() - 3e5 / 0.8, first_Pa * std::exp(-k * kTick_s / tau_s), 1e-3)
        << "Pa after " << k << " ticks";
  }
}

TEST(HeatTransfer, GasThatBeginsWarmOrColdComesToTheWallsTemperatureWithItsOwnTimeConstant) {
  const double conductance_W_K = 0.2, at_wall_Pa = 2.6e5;
  const Figures figures = with(sealed(), kIdHeatTransfer, {conductance_W_K, 1.4, 0.0, 20.0});
  const Drive drive = instants(std::vector<double>(300, 5.0), plant::VolumeMotion(160e-6), 64);
  const double c_v = Surroundings{}.gas.specific_gas_constant_J_kg_K() / 0.4;
  const double tau_s = c_v * at_wall_Pa * 160e-6 / RT() / (conductance_W_K * (160.0 + 20.0) / 100.0);
  for (const double warmth_Pa : {4e4, -3e4}) {
    const std::vector<double> p =
        run(only(kIdHeatTransfer), figures, drive, at_wall_Pa + warmth_Pa, {}, warmth_Pa);
    for (std::size_t k = 0; k < p.size(); ++k) {
      ASSERT_NEAR(p[k] - at_wall_Pa, warmth_Pa * std::exp(-static_cast<double>(k) * kTick_s / tau_s), 1e-3)
          << "Pa after " << k << " ticks";
    }
  }
}

TEST(HeatTransfer, ConductanceGrowsWithThePowerOfThePressureAndWithTheWall) {
  const double mass_kg = 4e-4, ambient_Pa = 101325.0, gas_constant = 287.0;
  for (const double power : {0.0, 0.5, 0.8}) {
    const double x[] = {0.3, 1.4, power, 50.0, 0.0};
    HeatTransfer<double> heat;
    heat.prepare(x, gas_constant, ambient_Pa, mass_kg);
    for (const double pressure_Pa : {2e4, 1e5, 3e5, 1.2e6}) {
      const double conductance_W_K = 0.3 * std::pow(pressure_Pa / ambient_Pa, power) * (120.0 + 50.0) / 100.0;
      const double expected_1_s = conductance_W_K / (gas_constant / 0.4 * mass_kg);
      EXPECT_NEAR(heat.relaxation_1_s(mass_kg, pressure_Pa, 120e-6) / expected_1_s, 1.0, 1e-6)
          << pressure_Pa << " Pa, power " << power;
    }
  }
}

/// A chamber of 160 mL that blows down from 700 kPa through a choked port, 2 mm2 open, all of the gas's temperature leaving with
/// it: without heat that is an isentropic change of what stays, of which the share x is left,
///   T = T_0 x^(k-1),  p = p_0 x^k,  x = (1 + (k-1)/2 t/tau)^(-2/(k-1)),  tau = v/(R T_0 A beta).
struct BlowDown {
  static constexpr double kStart_Pa = 7e5, kVolume_m3 = 160e-6, kOpen_m2 = 2e-6;
  static double left(double t_s) {
    const double tau_s = kVolume_m3 / (RT() * kOpen_m2 * plant::thin_plate_constants({}).beta_s_m);
    return std::pow(1.0 + 0.2 * t_s / tau_s, -5.0);
  }
};

TEST(HeatTransfer, BlowDownOfGasThatLeavesWithItsOwnTemperatureIsIsentropic) {
  const Figures figures = with(sharp_valve(1e-6), kIdHeatTransfer, {0.0, 1.4, 0.0, 0.0, 1.0});
  const Drive drive = instants(std::vector<double>(60, 3.0), plant::VolumeMotion(BlowDown::kVolume_m3), 32);
  const std::vector<double> p = run(only(kIdHeatTransfer), figures, drive, BlowDown::kStart_Pa);
  ASSERT_LT(p.back(), 300e3) << "Pa: most of it is gone";
  for (std::size_t k = 0; k < p.size() && p[k] > 200e3; ++k) {
    const double x = BlowDown::left(static_cast<double>(k) * kTick_s);
    ASSERT_NEAR(p[k], BlowDown::kStart_Pa * std::pow(x, 1.4), 20.0) << "Pa, row " << k;
  }
}

TEST(HeatTransfer, WhatABlowDownLeftBehindComesToTheWallsTemperatureWithItsMass) {
  // sealed after it: the wall warms it until p v = m R T_0
  const Figures figures = with(sharp_valve(1e-6), kIdHeatTransfer, {4e-3, 1.4, 0.0, 0.0, 1.0});
  std::vector<double> command_V(60001, 5.0);
  constexpr std::size_t kOpen = 20;
  std::fill_n(command_V.begin(), kOpen, 3.0);
  const Drive drive = instants(command_V, plant::VolumeMotion(BlowDown::kVolume_m3), 16);
  const std::vector<double> p = run(only(kIdHeatTransfer), figures, drive, BlowDown::kStart_Pa);
  const double x = BlowDown::left(kOpen * kTick_s);
  EXPECT_NEAR(p[kOpen] / (BlowDown::kStart_Pa * std::pow(x, 1.4)), 1.0, 3e-3);
  EXPECT_NEAR(p.back() / (BlowDown::kStart_Pa * x), 1.0, 1e-3);
}

TEST(HeatTransfer, NoGasIsMadeOrLostInACycleOfASealedChamber) {
  const Figures figures = with(sealed(), kIdHeatTransfer, {0.5, 1.4});
  // three swings, then a rest of 40 s in which the gas takes the wall's temperature
  Drive drive = instants(std::vector<double>(4001, 5.0), plant::VolumeMotion(200e-6), 16);
  for (std::size_t i = 0; i < drive.volume_m3.size(); ++i) {
    const double t = static_cast<double>(i) * kTick_s / 16.0;
    if (t < 1.5)
      drive.volume_m3[i] = 200e-6 * (1.0 - 0.3 * std::pow(std::sin(2.0 * std::numbers::pi * t), 2));
  }
  const std::vector<double> p = run(only(kIdHeatTransfer), figures, drive, 4e5);
  EXPECT_NEAR(p.back(), 4e5, 0.01) << "Pa";
}

}  // namespace
}  // namespace plenum::host::effects
