// The table of areas against valves of the plant, which shares no code with it.
#include "host-sim/identify/chamber/area_table.hpp"

#include <gtest/gtest.h>

#include "host-sim/reproduce/actuators/population.hpp"

namespace plenum::host::identify::chamber {
namespace {

using reproduce::actuators::record_under_pid;

constexpr std::size_t kRows = 3000;

/// Of `valve` on 150 mL that double at 1.1 Hz, between the defaults' pressures. Nothing of it is in the scene but the logs.
Scene scene_of(const plant::ThinPlateValveConfig& valve, double average_s = 0.01) {
  std::mt19937_64 random(7);
  plant::ChamberConfig config;
  config.initial_pressure_Pa = 200e3;
  plant::ChamberPlant chamber(plant::ThinPlateValve(valve), config,
                              plant::VolumeMotion(150e-6, {plant::VolumeSine{50e-6, 1.1, 0.3}}));
  Scene scene = make_scene({});
  trace::Log log = record_under_pid(random, chamber, 2.0, 8.0, kRows);
  log.pressure_average_s = average_s;
  add_record(scene, make_record("log", log, 1.0));
  return scene;
}

TEST(AreaTable, HoldsTheAreasOfThePlantsValveWhereItsCommandsAre) {
  const plant::ThinPlateValveConfig truth{.open_above_V = 5.3, .exhaust_below_V = 4.8, .transition_m2 = 2e-7};
  const plant::ThinPlateValve valve(truth);
  const AreaTable table = area_table(scene_of(truth));
  int held_against = 0;
  for (Eigen::Index i = 0; i < kMostNodes; ++i) {
    const double u = table.command_V[static_cast<std::size_t>(i)];
    if (u < 3.5 || u > 6.5) continue;
    ++held_against;
    EXPECT_NEAR(table.area_m2[i], valve.opening(u).inlet_m2, 8e-8) << "inlet at " << u << " V";
    EXPECT_NEAR(table.area_m2[kMostNodes + i], valve.opening(u).exhaust_m2, 8e-8)
        << "exhaust at " << u << " V";
  }
  EXPECT_GT(held_against, 10);
}

TEST(AreaTable, HasNoAreaBelowZero) {
  const AreaTable table = area_table(scene_of({.inlet_leak_m2 = 0.0, .exhaust_leak_m2 = 0.0}));
  EXPECT_GE(table.area_m2.minCoeff(), 0.0);
}

TEST(NearestValve, IsFoundWhereTheNullAndTheDeadBandAreFarFromTheDataSheetsAndTheGainsThreefold) {
  const plant::ThinPlateValveConfig truth{.open_above_V = 6.1,
                                          .exhaust_below_V = 4.7,
                                          .inlet_area_per_V_m2 = 4.5e-6,
                                          .exhaust_area_per_V_m2 = 3.1e-6,
                                          .transition_m2 = 2e-7};
  const Scene scene = scene_of(truth);
  const effects::Figures found = nearest_valve(area_table(scene), scene.nominal, 0);
  EXPECT_NEAR(found[effects::kOpenAbove], truth.open_above_V, 0.05);
  EXPECT_NEAR(found[effects::kExhaustBelow], truth.exhaust_below_V, 0.05);
  EXPECT_NEAR(found[effects::kInletGain] / truth.inlet_area_per_V_m2, 1.0, 0.1);
  EXPECT_NEAR(found[effects::kExhaustGain] / truth.exhaust_area_per_V_m2, 1.0, 0.1);
}

TEST(NearestValve, LeavesAThousandthOfWhatAShutValveErrsByAndNoMoreWithAShape) {
  const Scene scene = scene_of({});
  const AreaTable table = area_table(scene);
  const effects::EffectSet shape = effects::EffectSet{1} << effects::kIdAreaShape;
  const double shut = table.area_m2.dot(table.weight * table.area_m2);
  const double straight = table.squares(nearest_valve(table, scene.nominal, 0), 0);
  EXPECT_LT(straight, 1e-3 * shut);
  EXPECT_LE(table.squares(nearest_valve(table, scene.nominal, shape), shape), 1.001 * straight);
}

}  // namespace
}  // namespace plenum::host::identify::chamber
