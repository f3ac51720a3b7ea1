#include "host-sim/plant/servo/cylinder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace plenum::host::plant::servo {
namespace {

ValvePair shut() {
  ThinPlateValveConfig sealed;
  sealed.inlet_area_per_V_m2 = sealed.exhaust_area_per_V_m2 = 0.0;
  sealed.inlet_leak_m2 = sealed.exhaust_leak_m2 = sealed.transition_m2 = 0.0;
  const ThinPlateValve valve(sealed);
  return std::array<ThinPlateValve, 2>{valve, valve};
}

ValvePair five_three(const ThinPlateValveConfig& config = {}) {
  const ThinPlateValve valve(config);
  return std::array<ThinPlateValve, 2>{valve, valve};
}

ServoCylinderConfig balanced(const Friction& friction) {
  ServoCylinderConfig config;
  config.friction = friction;
  const double P_2 = 3e5;
  config.initial_pressure_2_Pa = P_2;
  config.initial_pressure_1_Pa =
      (P_2 * config.piston_area_2_m2 + config.ambient_Pa * config.rod_area_m2()) / config.piston_area_1_m2;
  return config;
}

// Internal energy of both gases, kinetic energy, and the work done on ambient by the rod [J].
double energy_J(const ServoCylinder& cylinder) {
  const ServoCylinderConfig& c = cylinder.config();
  const double x = cylinder.position_m();
  const double v = cylinder.velocity_m_s();
  return (cylinder.pressure_Pa(0) * volume_of(c, 0, x, v).volume_m3 +
          cylinder.pressure_Pa(1) * volume_of(c, 1, x, v).volume_m3) /
             (c.gas.kappa - 1.0) +
         0.5 * c.moving_mass_kg * v * v + (c.ambient_Pa * c.rod_area_m2() + c.external_force_N) * x;
}

TEST(ServoCylinder, OscillatesOnItsGasSpringsAtTheClosedFormFrequency) {
  ServoCylinderConfig config = balanced({0.0, 0.0, 0.01, 0.0});
  config.external_force_N = 0.2;  // a small push off balance
  ServoCylinder cylinder(shut(), config);
  const double k = config.gas.kappa;
  const auto spring = [&](int j, double area_m2, double P) {
    return k * P * area_m2 * area_m2 / volume_of(config, j, 0.0, 0.0).volume_m3;
  };
  const double stiffness = spring(0, config.piston_area_1_m2, config.initial_pressure_1_Pa) +
                           spring(1, config.piston_area_2_m2, config.initial_pressure_2_Pa);
  const double omega = std::sqrt(stiffness / config.moving_mass_kg);
  const double amplitude = 0.2 / stiffness;
  for (int i = 0; i < 400; ++i) {
    cylinder.advance({5.0, 5.0}, 1e-3);
    const double expected = -amplitude * (1.0 - std::cos(omega * cylinder.time_s()));
    ASSERT_NEAR(cylinder.position_m(), expected, 2e-3 * amplitude) << "t = " << cylinder.time_s() << " s";
  }
}

TEST(ServoCylinder, KeepsMassAndEnergyBehindShutPortsWithoutFriction) {
  ServoCylinderConfig config = balanced({0.0, 0.0, 0.01, 0.0});
  config.external_force_N = 60.0;
  ServoCylinder cylinder(shut(), config);
  const CylinderVector start = cylinder.state();
  const double energy_start_J = energy_J(cylinder);
  double travel_m = 0.0;
  for (int i = 0; i < 300; ++i) {
    cylinder.advance({5.0, 5.0}, 1e-2);
    travel_m = std::max(travel_m, std::abs(cylinder.position_m()));
    ASSERT_EQ(cylinder.state()[kMass1], start[kMass1]);
    ASSERT_EQ(cylinder.state()[kMass2], start[kMass2]);
    ASSERT_NEAR(energy_J(cylinder), energy_start_J, 1e-5 * energy_start_J);
  }
  EXPECT_GT(travel_m, 0.02);  // the gas did work
}

TEST(ServoCylinder, CoulombFrictionTakesItsForceTimesThePathAndThenThePistonRests) {
  const double F_c = 4.0;
  ServoCylinderConfig config = balanced({F_c, 0.0, 0.01, 0.0});
  config.external_force_N = 60.0;
  ServoCylinder cylinder(shut(), config);
  const double energy_start_J = energy_J(cylinder);
  double path_m = 0.0;
  double x = cylinder.position_m();
  for (int i = 0; i < 40000; ++i) {
    cylinder.advance({5.0, 5.0}, 1e-4);
    path_m += std::abs(cylinder.position_m() - x);
    x = cylinder.position_m();
  }
  EXPECT_EQ(cylinder.motion(), Motion::kStuck);
  EXPECT_EQ(cylinder.velocity_m_s(), 0.0);
  EXPECT_GT(path_m, 0.05);
  EXPECT_NEAR(energy_start_J - energy_J(cylinder), F_c * path_m, 1e-4 * F_c * path_m);
}

TEST(ServoCylinder, StuckPistonDoesNotMoveByABitBelowBreakaway) {
  ServoCylinderConfig config = balanced({30.0, 15.0, 0.02, 80.0});
  config.initial_position_m = 0.0123456789;
  ServoCylinder cylinder(shut(), config);
  for (int i = 0; i < 2000; ++i) {  // the load swings up to 44.9 of the 45 N
    cylinder.set_external_force_N(44.9 * std::sin(0.05 * i));
    cylinder.advance({5.0, 5.0}, 5e-3);
    ASSERT_EQ(cylinder.position_m(), 0.0123456789) << "t = " << cylinder.time_s() << " s";
    ASSERT_EQ(cylinder.velocity_m_s(), 0.0);
    ASSERT_EQ(cylinder.motion(), Motion::kStuck);
    ASSERT_NEAR(cylinder.friction_N(), -44.9 * std::sin(0.05 * i), 1e-6);
  }
  cylinder.set_external_force_N(45.1);
  cylinder.advance({5.0, 5.0}, 1e-3);
  EXPECT_EQ(cylinder.motion(), Motion::kBackward);
}

TEST(ServoCylinder, LetsGoAtTheInstantOfTheClosedForm) {
  // choked filling of chamber 1 at constant temperature: P_1 rises at R T mdot / V_1 until A_1 (P_1 - P_a)
  // reaches F_c + F_s
  ServoCylinderConfig config;
  config.law = Polytropic{1.0};
  config.friction = {30.0, 15.0, 0.02, 80.0};
  ThinPlateValveConfig sharp;
  sharp.inlet_leak_m2 = sharp.exhaust_leak_m2 = sharp.transition_m2 = 0.0;
  ServoCylinder cylinder(five_three(sharp), config);
  const double area_m2 = sharp.inlet_area_per_V_m2 * (6.0 - sharp.open_above_V);
  const double mdot = area_m2 * thin_plate_constants(config.gas).beta_s_m * config.supply_Pa;
  const double rate_Pa_s = config.gas.specific_gas_constant_J_kg_K() * config.gas.temperature_K * mdot /
                           volume_of(config, 0, 0.0, 0.0).volume_m3;
  const double release_s = 45.0 / config.piston_area_1_m2 / rate_Pa_s;
  cylinder.advance({6.0, 4.0}, release_s - 1e-7);
  EXPECT_EQ(cylinder.motion(), Motion::kStuck);
  EXPECT_EQ(cylinder.position_m(), 0.0);
  cylinder.advance({6.0, 4.0}, 2e-7);
  EXPECT_EQ(cylinder.motion(), Motion::kForward);
}

TEST(ServoCylinder, CreepsInStickAndSlipWhenDrivenSlowly) {
  ServoCylinderConfig config;
  config.friction = {5.0, 10.0, 0.01, 20.0};
  config.moving_mass_kg = 1.0;
  ThinPlateValveConfig small;
  small.inlet_area_per_V_m2 = small.exhaust_area_per_V_m2 = 2e-8;
  small.inlet_leak_m2 = small.exhaust_leak_m2 = small.transition_m2 = 0.0;
  ServoCylinder cylinder(five_three(small), config);
  int at_rest = 0;
  double last_m = cylinder.position_m();
  for (int i = 0; i < 8000; ++i) {
    cylinder.advance({6.0, 4.0}, 1e-3);
    if (cylinder.motion() == Motion::kStuck) {
      ++at_rest;
      ASSERT_EQ(cylinder.velocity_m_s(), 0.0);
    }
    ASSERT_GE(cylinder.position_m(), last_m - 1e-12);
    last_m = cylinder.position_m();
  }
  EXPECT_GE(cylinder.slips(), 5u);
  EXPECT_GT(at_rest, 300);
  EXPECT_LT(at_rest, 7900);
}

TEST(ServoCylinder, MirroredCommandsMirrorTheMotionOfACylinderWithRodsOnBothSides) {
  ServoCylinderConfig config;
  config.piston_area_1_m2 = config.piston_area_2_m2;
  config.spool = SpoolConfig{65.0, 0.7};
  ServoCylinder right(five_three(), config);
  ServoCylinder left(five_three(), config);
  for (int i = 0; i < 60; ++i) {
    const double u = 5.0 + 0.9 * std::sin(0.21 * i);
    right.advance({u, 10.0 - u}, 1e-2);
    left.advance({10.0 - u, u}, 1e-2);
    ASSERT_NEAR(right.position_m(), -left.position_m(), 1e-9) << "t = " << right.time_s() << " s";
    ASSERT_NEAR(right.pressure_Pa(0), left.pressure_Pa(1), 1e-2);
  }
  EXPECT_GT(std::abs(right.position_m()), 1e-3);
}

TEST(ServoCylinder, TwoValvesThatFillBothChambersStiffenItWithoutMotion) {
  ServoCylinderConfig config;
  config.piston_area_1_m2 = config.piston_area_2_m2;  // a rod on both sides: nothing pushes
  config.friction = {0.0, 0.0, 0.01, 80.0};
  ServoCylinder cylinder(five_three(), config);
  cylinder.advance({5.8, 5.8}, 0.5);
  EXPECT_NEAR(cylinder.position_m(), 0.0, 1e-12);
  EXPECT_NEAR(cylinder.pressure_Pa(0), cylinder.pressure_Pa(1), 1e-6);
  EXPECT_GT(cylinder.pressure_Pa(0), 3.0 * config.initial_pressure_1_Pa);
}

TEST(ServoCylinder, ToleranceDoesNotShapeTheMotion) {
  ServoCylinderConfig config;
  config.spool = SpoolConfig{65.0, 0.7};
  ServoCylinder coarse(five_three(), config);
  config.tolerance = 1e-10;
  ServoCylinder fine(five_three(), config);
  for (int i = 0; i < 100; ++i) {
    const double u = (i / 20) % 2 == 0 ? 5.7 : 4.4;
    coarse.advance(five_three_commands_V(u), 1e-2);
    fine.advance(five_three_commands_V(u), 1e-2);
    ASSERT_NEAR(coarse.position_m(), fine.position_m(), 2e-6) << "t = " << fine.time_s() << " s";
    ASSERT_NEAR(coarse.pressure_Pa(0), fine.pressure_Pa(0), 20.0);
  }
  EXPECT_GE(fine.sticks(), 1u);
  EXPECT_EQ(coarse.slips(), fine.slips());
}

TEST(ServoCylinder, StopsAtTheEndOfItsStrokeAndComesBack) {
  ServoCylinderConfig config;
  ServoCylinder cylinder(five_three(), config);
  cylinder.advance({8.0, 2.0}, 1.0);
  EXPECT_EQ(cylinder.position_m(), 0.5 * config.stroke_m);
  EXPECT_EQ(cylinder.velocity_m_s(), 0.0);
  EXPECT_EQ(cylinder.friction_N(), 0.0);  // the stop carries the force
  EXPECT_NEAR(cylinder.pressure_Pa(0), config.supply_Pa, 0.02 * config.supply_Pa);
  cylinder.advance({2.0, 8.0}, 1.0);
  EXPECT_EQ(cylinder.position_m(), -0.5 * config.stroke_m);
}

TEST(ServoCylinder, MassOfChamberFollowsThePortsUnderEveryLawThatKeepsTheGasLaw) {
  // isothermal: P V = m R T all along; with T of the energy balance likewise, by its own temperature
  for (const ChamberLaw& law : {ChamberLaw{Polytropic{1.0}}, ChamberLaw{MixedExponents{1.0, 1.0, 1.0}}}) {
    ServoCylinderConfig config;
    config.law = law;
    ServoCylinder cylinder(five_three(), config);
    for (int i = 0; i < 80; ++i) {
      cylinder.advance(five_three_commands_V((i / 20) % 2 == 0 ? 5.7 : 4.4), 1e-2);
      for (int j = 0; j < 2; ++j) {
        const double V = volume_of(config, j, cylinder.position_m(), 0.0).volume_m3;
        const double m = cylinder.state()[j == 0 ? kMass1 : kMass2];
        ASSERT_NEAR(mass_of_kg(config.gas, cylinder.pressure_Pa(j), V, config.gas.temperature_K) / m, 1.0,
                    1e-5);
      }
    }
  }
}

TEST(ServoCylinder, RunsOnTheMeasuredValve) {
  const std::array<MpyeValve, 2> ports{MpyeValve(MpyeChannel::a), MpyeValve(MpyeChannel::b_mirrored)};
  ServoCylinderConfig config;
  config.gas = reference_atmosphere();
  config.ambient_Pa = 1e5;
  ServoCylinder cylinder(ports, config);
  cylinder.advance(five_three_commands_V(6.5), 0.3);
  EXPECT_GT(cylinder.position_m(), 0.01);
  const double reached_m = cylinder.position_m();
  cylinder.advance(five_three_commands_V(3.5), 0.5);
  EXPECT_LT(cylinder.position_m(), reached_m);
}

TEST(ServoCylinder, RefusesWhatIsOutOfRangeAndNamesIt) {
  ServoCylinderConfig config;
  config.initial_position_m = 0.2;
  try {
    const ServoCylinder cylinder(shut(), config);
    FAIL() << "a piston beyond its stroke was accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("initial_position_m"), std::string::npos) << e.what();
  }
  ServoCylinder cylinder(shut(), {});
  EXPECT_THROW(cylinder.advance({std::nan(""), 5.0}, 0.01), std::invalid_argument);
  EXPECT_THROW(cylinder.advance({5.0, 5.0}, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::plant::servo
