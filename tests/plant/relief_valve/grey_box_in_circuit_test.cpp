#include "host-sim/plant/relief_valve/grey_box_in_circuit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace {

using namespace plenum::host::plant::relief_valve;

const GreyBoxCircuitConfig kCircuit{
    .valve = {.k1_m2_Pa = 1e-11, .k3_m2 = -5e-5, .lag_s = 0.02, .density_kg_m3 = 865.0},
    .upstream_volume_m3 = 4e-3,
    .bulk_modulus_Pa = 1.4e9};

TEST(GreyBoxInCircuit, AtRestItStaysAtRest) {
  GreyBoxInCircuit circuit(kCircuit, 1e-3);
  const double before_Pa = circuit.pressure_Pa();
  for (int i = 0; i < 100; ++i) circuit.advance(1e-3, 1e-3, 1e-3);
  EXPECT_NEAR(circuit.pressure_Pa(), before_Pa, 1e-3);
  EXPECT_NEAR(circuit.valve_flow_m3_s(), 1e-3, 1e-12);
}

TEST(GreyBoxInCircuit, WhatComesInAndDoesNotLeaveIsCompressed) {
  GreyBoxInCircuit circuit(kCircuit, 0.0);
  constexpr double kStep_s = 1e-5;
  double stored_m3 = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double left = circuit.valve_flow_m3_s();
    circuit.advance(1e-3, 1e-3, kStep_s);
    stored_m3 += kStep_s * (1e-3 - 0.5 * (left + circuit.valve_flow_m3_s()));
  }
  EXPECT_NEAR(stored_m3 * kCircuit.bulk_modulus_Pa / kCircuit.upstream_volume_m3, circuit.pressure_Pa(),
              1e-5 * circuit.pressure_Pa());
}

TEST(GreyBoxInCircuit, ShutItRisesWithTheSupplyAndCracksOnTime) {
  GreyBoxInCircuit circuit(kCircuit, 0.0);
  circuit.advance(0.0, 1e-3, 0.01);
  EXPECT_NEAR(circuit.pressure_Pa(), 1.4e9 / 4e-3 * 0.5 * 1e-3 * 0.01, 1e-3);
  EXPECT_EQ(circuit.valve_flow_m3_s(), 0.0);
}

// Linearised: omega^2 = (beta/V) (k1 sqrt(2P/rho) / lag + dQ/dP / lag), damping by both.
TEST(GreyBoxInCircuit, SmallOscillationsHaveTheLinearisedFrequency) {
  GreyBoxInCircuit circuit(kCircuit, 1e-3);
  const double P = circuit.pressure_Pa();
  const double stiff = 1.4e9 / 4e-3;
  const double by_opening = std::sqrt(2.0 * P / 865.0);
  const double by_pressure = 0.5 * 1e-3 / P;
  const double trace = -stiff * by_pressure - 1.0 / 0.02;
  const double det = stiff * (by_pressure + by_opening * 1e-11) / 0.02;
  const double omega = std::sqrt(det - 0.25 * trace * trace);
  // Crossings of the new steady state after a small step; the first is where the step started to be taken up.
  GreyBoxInCircuit after(kCircuit, 1.001e-3);
  double last = circuit.pressure_Pa() - after.pressure_Pa();
  std::vector<double> crossings;
  constexpr double kStep_s = 1e-5;
  for (int i = 1; crossings.size() < 3; ++i) {
    circuit.advance(1.001e-3, 1.001e-3, kStep_s);
    const double now = circuit.pressure_Pa() - after.pressure_Pa();
    if (last * now < 0.0) crossings.push_back(kStep_s * (i - now / (now - last)));
    last = now;
    ASSERT_LT(i, 100000);
  }
  EXPECT_NEAR(2.0 * std::numbers::pi / (crossings[2] - crossings[0]), omega, 2e-3 * omega) << "rad/s";
}

TEST(GreyBoxInCircuit, OpeningFromShutDoesNotDependOnTheTimeStep) {
  const auto end = [](int steps) {
    GreyBoxInCircuit circuit(kCircuit, 0.0);
    for (int i = 0; i < steps; ++i) circuit.advance(1e-3, 1e-3, 0.04 / steps);
    return circuit.pressure_Pa();
  };
  EXPECT_NEAR(end(100), end(10000), 1e-4 * end(10000));
}

TEST(GreyBoxInCircuit, CracksWithinAStepOfARisingSupply) {
  const auto end = [](int steps) {
    GreyBoxInCircuit circuit(kCircuit, 0.0);
    for (int i = 0; i < steps; ++i) circuit.advance(2e-3 * i / steps, 2e-3 * (i + 1) / steps, 0.02 / steps);
    return circuit.pressure_Pa();
  };
  EXPECT_NEAR(end(7), end(7000), 2e-4 * end(7000)) << "Pa";
}

TEST(GreyBoxInCircuit, ShutsWhenTheSupplyStopsAndHoldsPressure) {
  GreyBoxInCircuit circuit(kCircuit, 1e-3);
  for (int i = 0; i < 3000; ++i) circuit.advance(0.0, 0.0, 1e-3);
  const double held_Pa = circuit.pressure_Pa();
  EXPECT_LE(held_Pa, 5e6);
  EXPECT_GT(held_Pa, 0.0);
  circuit.advance(0.0, 0.0, 1e-3);
  EXPECT_NEAR(circuit.pressure_Pa(), held_Pa, 10.0);
}

TEST(GreyBoxInCircuit, RefusesAValveWithoutLag) {
  GreyBoxCircuitConfig config = kCircuit;
  config.valve.lag_s = 0.0;
  EXPECT_THROW(GreyBoxInCircuit(config, 1e-3), std::invalid_argument);
  EXPECT_THROW(GreyBoxInCircuit(kCircuit, -1.0), std::invalid_argument);
}

}  // namespace
