#include "host-sim/reproduce/proportional_valve/walled_vessel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "host-sim/plant/chamber.hpp"
#include "host-sim/reproduce/proportional_valve/experiment.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

const plant::Gas kGas = plant::reference_atmosphere();
const plant::MpyeValve kChannelA(plant::MpyeChannel::a, kGas);

plant::ChamberPlant papers_chamber(double start_Pa) {
  plant::ChamberConfig config;
  config.gas = kGas;
  config.supply_Pa = kSupply_Pa;
  config.ambient_Pa = kAmbient_Pa;
  config.initial_pressure_Pa = start_Pa;
  config.tolerance_Pa = 0.1;
  return {kChannelA, config, plant::VolumeMotion(kVessel_m3)};
}

// Pressures every millisecond of one command.
template <class Vessel>
double greatest_distance_Pa(WalledVessel walled, Vessel other, double command_V, double duration_s) {
  double most = 0.0;
  for (double t = 0.0; t < duration_s; t += 1e-3) {
    walled.advance(command_V, 1e-3);
    other.advance(command_V, 1e-3);
    most = std::fmax(most, std::abs(walled.pressure_Pa() - other.pressure_Pa()));
  }
  return most;
}

// What enters brings gamma C_v T_0 mdot: (7) with alpha_in = 1.4, written a second time. Both integrators are
// coarsest where a wide open inlet shuts as a root; a sample's noise is 200 Pa.
TEST(WalledVessel, ChargesWithoutHeatAsAlphaOfGamma) {
  for (const double command_V : {6.0, 10.0}) {
    EXPECT_LT(greatest_distance_Pa(WalledVessel(kChannelA, kGas, kAmbient_Pa, {0.0, kGas.temperature_K}),
                                   papers_chamber(kAmbient_Pa), command_V, 0.5),
              40.0)
        << command_V << " V";
  }
}

// The distance vanishes as 1 / G_w.
TEST(WalledVessel, DischargesByAConductingWallAsAlphaOfOne) {
  const auto distance_Pa = [](double conductance_W_K) {
    return greatest_distance_Pa(
        WalledVessel(kChannelA, kGas, kSupply_Pa, {conductance_W_K, kGas.temperature_K}),
        papers_chamber(kSupply_Pa), 4.2, 1.0);
  };
  const double at_3000 = distance_Pa(3e3);
  EXPECT_LT(at_3000, 1e-3 * kSupply_Pa);
  EXPECT_NEAR(distance_Pa(1.5e3) / at_3000, 2.0, 0.1);
  EXPECT_GT(distance_Pa(0.0), 0.05 * kSupply_Pa);
}

TEST(WalledVessel, CoolsAsItEmptiesAndWarmsAgain) {
  WalledVessel vessel(kChannelA, kGas, kSupply_Pa, {1.0, kGas.temperature_K});
  vessel.advance(0.0, 0.1);
  EXPECT_LT(vessel.temperature_K(), kGas.temperature_K - 50.0);
  vessel.advance(0.0, 5.0);
  EXPECT_NEAR(vessel.temperature_K(), kGas.temperature_K, 0.5);
}

TEST(WalledVessel, DoesNotDependOnHowItsTimeIsCut) {
  WalledVessel whole(kChannelA, kGas, kAmbient_Pa, {1.0, kGas.temperature_K});
  WalledVessel cut = whole;
  whole.advance(8.0, 0.1);
  for (int i = 0; i < 1000; ++i) cut.advance(8.0, 1e-4);
  EXPECT_NEAR(whole.pressure_Pa(), cut.pressure_Pa(), 1.0);
}

TEST(Experiment, TakesAWallOrASpool) {
  RigOptions options;
  options.spool = plant::SpoolConfig{65.0, 0.7};
  options.wall = plant::servo::EnergyBalance{1.0, kGas.temperature_K};
  EXPECT_THROW(measure(all_series()[0], 7.0, options), std::invalid_argument);
}

TEST(Experiment, WithAWallStartsFromTheSamePressures) {
  RigOptions options;
  options.wall = plant::servo::EnergyBalance{1.0, kGas.temperature_K};
  EXPECT_NEAR(measure(all_series()[0], 6.2, options).vessel_truth_Pa.front(), 1.012e5, 300.0);
  EXPECT_NEAR(measure(all_series()[1], 4.0, options).vessel_truth_Pa.front(), 7e5, 300.0);
}

}  // namespace
}  // namespace plenum::host::reproduce::proportional_valve
