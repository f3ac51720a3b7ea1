#include "host-sim/plant/regulator_valve/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace plenum::host::plant::regulator_valve {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(RegulatorValveConfig, BlockedFlowIsTheConstantPrintedInTable3) {
  EXPECT_NEAR(blocked_flow_s_m(table3_air()), 2.34e-3, 0.005e-3);
  // by hand: sqrt(1.4 / (287.04 * 298) * (2 / 2.4)^6)
  EXPECT_NEAR(blocked_flow_s_m(table3_air()), std::sqrt(1.4 / 85537.92 * std::pow(5.0 / 6.0, 6.0)), 1e-12);
  EXPECT_NEAR(gamma_R_T_J_kg(table3_air()), 1.4 * 287.04 * 298.0, 1e-6);
}

TEST(RegulatorValveConfig, TheScrewTurnsThroughTheDeadBandWhileTheSpoolOverlapsItsPort) {
  ValveConfig valve = bench_valve();
  // at the pressure where the inlet shuts, k_me x_p = (k_me + k_mc) d more than where the exhaust shuts
  EXPECT_NEAR((valve.plunger_spring_N_m + valve.spool_spring_N_m) * overlap_m(valve),
              valve.plunger_spring_N_m * 0.9e-3, 1e-12);
  valve.dead_band_m = 0.0;
  EXPECT_EQ(overlap_m(valve), 0.0);
}

TEST(RegulatorValveConfig, RefusesWhatIsNoValveAndNamesTheField) {
  ValveConfig valve = bench_valve();
  valve.spool_mass_kg = 0.0;
  EXPECT_THAT([&] { validate(valve); }, ThrowsMessage<std::invalid_argument>(HasSubstr("spool_mass_kg: 0")));
  valve = bench_valve();
  valve.supply_Pa = valve.ambient_Pa;
  EXPECT_THAT([&] { validate(valve); }, ThrowsMessage<std::invalid_argument>(HasSubstr("supply_Pa")));
  valve = bench_valve();
  valve.dead_band_m = -1e-3;
  EXPECT_THAT([&] { validate(valve); }, ThrowsMessage<std::invalid_argument>(HasSubstr("dead_band_m")));
  valve.dead_band_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(validate(valve), std::invalid_argument);
  EXPECT_THAT([] { bench_valve({.slope_Pa_m = -1.0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("slope_Pa_m: -1")));
}

TEST(RegulatorValveConfig, TheDefaultNamesWhatIsStillMissing) {
  EXPECT_THAT([] { validate(ValveConfig{}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("diaphragm_area_m2")));
}

}  // namespace
}  // namespace plenum::host::plant::regulator_valve
