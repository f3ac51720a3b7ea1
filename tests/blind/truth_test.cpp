#include "host-sim/blind/truth.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "host-sim/blind/blind_case.hpp"

namespace plenum::host::blind {
namespace {

Machine machine() {
  Machine made;
  made.rig.gas.temperature_K = 293.15;
  made.rig.supply.pressure_Pa = 700e3;
  made.rig.ambient.pressure_Pa = 101325.0;
  made.rig.valve.transition_m2 = 0.2e-6;
  made.motion.mean_m3 = 150e-6;
  made.initial_Pa = 150e3;
  return made;
}

/// Ports that are shut, up to what the smooth transition leaves when the threshold is far away.
void shut(Machine& m) {
  m.rig.valve.open_above_V = 1e6;
  m.rig.valve.exhaust_below_V = -1e6;
  m.rig.valve.inlet_leak_m2 = m.rig.valve.exhaust_leak_m2 = 0.0;
  m.rig.valve.transition_m2 = 1e-12;
}

Driver constant(double command_V) {
  return [command_V](std::size_t, double) { return command_V; };
}

TEST(BlindFlow, MeetsItsChokedLimitAndIsOdd) {
  const double ratio = std::pow(2.0 / 2.4, 1.4 / 0.4);
  const double choked = thin_plate_flux(5e5, 0.0, 293.15);
  EXPECT_NEAR(thin_plate_flux(5e5, 5e5 * ratio * (1 + 1e-9), 293.15) / choked, 1.0, 1e-12);
  // sqrt(k/(R T)) (2/(k+1))^((k+1)/(2(k-1))) p, with R = Z R/M of Table II
  const double rt = 0.99 * 8.31 / 0.029 * 293.15;
  EXPECT_NEAR(choked, 5e5 * std::sqrt(1.4 / rt) * std::pow(2.0 / 2.4, 3.0), 1e-9);
  EXPECT_EQ(thin_plate_flux(2e5, 4e5, 293.15), -thin_plate_flux(4e5, 2e5, 293.15));
  EXPECT_EQ(thin_plate_flux(2e5, 2e5, 293.15), 0.0);
}

TEST(BlindFlow, AreaFollowsTheContract) {
  // a(u) = L + w smax((B (u - U) - L)/w), smax(x) = (sqrt(x^2 + 1) + x)/2
  const double x = (1.5e-6 * 0.4 - 3e-8) / 2e-7;
  EXPECT_NEAR(port_area(0.4, 1.5e-6, 3e-8, 2e-7), 3e-8 + 2e-7 * 0.5 * (std::sqrt(x * x + 1) + x), 1e-20);
  EXPECT_NEAR(port_area(5.0, 1.5e-6, 3e-8, 2e-7), 7.5e-6, 2e-9);  // wide open: B (u - U)
  EXPECT_NEAR(port_area(-5.0, 1.5e-6, 3e-8, 2e-7), 3e-8, 2e-9);   // shut: L
}

/// A machine that fills from a supply so high that the inflow stays choked, hence constant.
Machine filling() {
  Machine m = machine();
  m.rig.supply.pressure_Pa = 2e6;
  m.rig.valve.exhaust_below_V = -1e6;
  m.rig.valve.exhaust_leak_m2 = 0.0;
  m.rig.valve.transition_m2 = 1e-12;
  return m;
}

TEST(BlindTruth, ChokedFillOfAFixedVolumeIsLinearInTime) {
  Machine m = filling();
  m.rig.sampling.pressure_average_s = 0.0;
  const Rows rows = simulate(m, 20, constant(5.3));
  const double area = port_area(5.3 - m.rig.valve.open_above_V, m.rig.valve.inlet_area_per_V_m2,
                                m.rig.valve.inlet_leak_m2, m.rig.valve.transition_m2);
  const double rate =
      1.4 * kGasConstant_J_kg_K * 293.15 / 150e-6 * 0.72 * area * thin_plate_flux(2e6, 0, 293.15);
  ASSERT_LT(rows.pressure_Pa.back(), 0.5 * 2e6);
  for (std::size_t k = 0; k < 20; ++k) {
    const double expected =
        150e3 + rate * (0.5 + 0.01 * static_cast<double>(k));  // half a second before row 0
    EXPECT_NEAR(rows.pressure_Pa[k], expected, 1e-3) << "Pa, row " << k;
  }
}

TEST(BlindTruth, ReadsTheMeanOverTheTimeBeforeTheRow) {
  Machine instant = filling();
  instant.rig.sampling.pressure_average_s = 0.0;
  Machine mean = instant;
  mean.rig.sampling.pressure_average_s = 0.01;
  const Rows a = simulate(instant, 10, constant(5.3)), b = simulate(mean, 10, constant(5.3));
  for (std::size_t k = 1; k < 10; ++k) {  // of a line: its middle
    EXPECT_NEAR(b.pressure_Pa[k], 0.5 * (a.pressure_Pa[k - 1] + a.pressure_Pa[k]), 0.5) << "Pa, row " << k;
  }
}

TEST(BlindTruth, SealedChamberHoldsItsPressure) {
  Machine m = machine();
  shut(m);
  const Rows rows = simulate(m, 300, constant(5.0));
  for (const double p : rows.pressure_Pa) EXPECT_NEAR(p, 150e3, 1e-3) << "Pa";
}

TEST(BlindTruth, SealedCompressionKeepsPressureTimesVolumeToTheKappa) {
  Machine m = machine();
  shut(m);
  m.rig.sampling.pressure_average_s = 0.0;
  m.motion.tones[0] = {0.3, 1.3, 0.4};
  m.motion.tones[1] = {0.08, 0.2, 2.0};
  const Rows rows = simulate(m, 400, constant(5.0));
  const double constant0 = rows.pressure_Pa[0] * std::pow(rows.volume_m3[0], kKappa);
  for (std::size_t k = 0; k < 400; ++k) {
    EXPECT_NEAR(rows.pressure_Pa[k] * std::pow(rows.volume_m3[k], kKappa) / constant0, 1.0, 1e-8)
        << "row " << k;
  }
}

TEST(BlindTruth, EquilibriumBalancesBothPorts) {
  Machine m = machine();
  std::swap(m.rig.valve.open_above_V, m.rig.valve.exhaust_below_V);  // both ports a little open
  const Rows rows = simulate(m, 3000, constant(5.0));
  const auto& v = m.rig.valve;
  const double p = rows.pressure_Pa.back();
  const double in = port_area(5.0 - v.open_above_V, v.inlet_area_per_V_m2, v.inlet_leak_m2, v.transition_m2) *
                    thin_plate_flux(700e3, p, 293.15);
  const double out =
      port_area(v.exhaust_below_V - 5.0, v.exhaust_area_per_V_m2, v.exhaust_leak_m2, v.transition_m2) *
      thin_plate_flux(p, 101325.0, 293.15);
  EXPECT_NEAR(in / out, 1.0, 1e-6);
}

TEST(BlindTruth, DeadTimeShiftsByExactlyItsDelay) {
  Machine m = machine();
  const auto wave = [](std::size_t row, double) {
    return row < 20 ? 5.0 : 5.0 + 0.7 * std::sin(0.3 * double(row));
  };
  const auto later = [&](std::size_t row, double p) { return row < 3 ? 5.0 : wave(row - 3, p); };
  Machine delayed = m;
  delayed.departures.dead_time = DeadTime{0.03};
  const Rows a = simulate(m, 300, later), b = simulate(delayed, 300, wave);
  EXPECT_EQ(a.pressure_Pa, b.pressure_Pa);
}

TEST(BlindTruth, DelayMayBeAnyFractionOfAStep) {
  Machine delayed = filling(), prompt = filling();
  constexpr double kDelay_s = 0.005 + 1.7e-5;
  delayed.departures.dead_time = DeadTime{kDelay_s};
  const auto jump = [](std::size_t row, double) { return row < 20 ? 5.0 : 5.3; };
  const Rows a = simulate(prompt, 25, jump), b = simulate(delayed, 25, jump);
  // The pressure is a line, so that the delay is its distance over the change of slope.
  const double slope = (a.pressure_Pa[24] - a.pressure_Pa[23] - a.pressure_Pa[19] + a.pressure_Pa[18]) / 0.01;
  EXPECT_NEAR((a.pressure_Pa[24] - b.pressure_Pa[24]) / slope, kDelay_s, 1e-9) << "s";
}

TEST(BlindTruth, RefusesAStepThatDoesNotDivideATick) {
  EXPECT_THROW(simulate(machine(), 10, constant(5.0), 3e-5), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::blind
