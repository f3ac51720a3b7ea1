#include "host-sim/plant/relief_valve/two_stage.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "host-sim/plant/relief_valve/inch_units.hpp"
#include "host-sim/plant/relief_valve/two_stage_static.hpp"

namespace {

using namespace plenum::host::plant::relief_valve;

constexpr TwoStageState kSomewhere{7e6, 6.3e6, 8e-4, 0.3, 2.5e-4, -0.2};

TEST(TwoStage, AtRestEveryRateVanishesAndTheFlowIsPassed) {
  for (const TwoStageConfig& config : {appendix_a_as_printed(), appendix_a_settling()}) {
    const TwoStagePhysics physics(config);
    for (const double flow_in3_s : {10.0, 50.0, 250.0}) {
      const double flow = flow_in3_s * kInch3_m3;
      const TwoStageState s = two_stage_at_rest(physics, flow);
      EXPECT_NEAR(physics.valve_flow_m3_s(s), flow, 1e-9 * flow);
      EXPECT_NEAR(physics.main_force_N(s), 0.0, 1e-6) << "N at " << flow_in3_s << " in3/s";
      EXPECT_NEAR(physics.pilot_force_N(s), 0.0, 1e-6) << "N at " << flow_in3_s << " in3/s";
      const double pilot = physics.pilot_flow_m3_s(s[kP2], s[kY]);
      EXPECT_NEAR(physics.capillary_flow_m3_s(s[kP1], s[kP2]), pilot, 1e-9 * pilot);
    }
  }
}

TEST(TwoStage, PilotCracksWhereItsSpringGivesWay) {
  // K_p y0 / A_p with A_p = pi/4 D6^2: 20 lbf on 0.0314 in2
  EXPECT_NEAR(pilot_cracking_Pa(appendix_a_as_printed()) / kPsi_Pa, 20.0 / (std::numbers::pi / 4.0 * 0.04),
              1e-6);
}

TEST(TwoStage, RestBelowTheOpeningOfTheSpoolIsRefused) {
  const TwoStagePhysics physics(appendix_a_settling());
  EXPECT_THROW(two_stage_at_rest(physics, 0.5 * least_main_flow_m3_s(physics)), std::invalid_argument);
  EXPECT_THROW(two_stage_at_rest(physics, 1.0), std::invalid_argument);
}

TEST(TwoStage, VolumeIsConserved) {
  // What is supplied is compressed, swept by the elements or has left through the two openings.
  const TwoStagePhysics physics(appendix_a_settling());
  const TwoStageConfig& config = physics.config();
  const double supply = 3e-3;
  const TwoStageState rate = physics.rate(kSomewhere, supply);
  const double compressed =
      (config.upstream_volume_m3 * rate[kP1] + config.chamber_volume_m3 * rate[kP2]) / config.bulk_modulus_Pa;
  const double swept = (config.main_area_m2 - config.main_chamber_area_m2) * kSomewhere[kV] +
                       config.pilot_area_m2 * kSomewhere[kU];
  const double left = physics.main_flow_m3_s(kSomewhere[kP1], kSomewhere[kX]) +
                      physics.pilot_flow_m3_s(kSomewhere[kP2], kSomewhere[kY]);
  EXPECT_NEAR(compressed + swept + left, supply, 1e-15);
}

TEST(TwoStage, SlopesAreThoseOfTheRates) {
  const TwoStagePhysics physics(appendix_a_settling());
  const TwoStagePhysics::Slopes j = physics.slopes(kSomewhere);
  const std::array<std::array<double, 6>, 6> J{{{j.P1_P1, j.P1_P2, j.P1_x, j.P1_v, 0, 0},
                                                {j.P2_P1, j.P2_P2, 0, j.P2_v, j.P2_y, j.P2_u},
                                                {0, 0, 0, 1, 0, 0},
                                                {j.v_P1, j.v_P2, j.v_x, j.v_v, 0, 0},
                                                {0, 0, 0, 0, 0, 1},
                                                {0, j.u_P2, 0, 0, j.u_y, j.u_u}}};
  const std::array<double, 6> size{1e6, 1e6, 1e-3, 1.0, 1e-3, 1.0};
  const TwoStageState at = physics.rate(kSomewhere, 1e-3);
  for (std::size_t n = 0; n < 6; ++n) {
    TwoStageState up = kSomewhere;
    TwoStageState down = kSomewhere;
    up[n] += 1e-5 * size[n];
    down[n] -= 1e-5 * size[n];
    const TwoStageState fu = physics.rate(up, 1e-3);
    const TwoStageState fd = physics.rate(down, 1e-3);
    for (std::size_t m = 0; m < 6; ++m) {
      const double numeric = (fu[m] - fd[m]) / (2e-5 * size[n]);
      EXPECT_NEAR(J[m][n], numeric, 1e-5 * std::abs(numeric) + 1e-9 * std::abs(at[m]) / size[n] + 1e-9)
          << "row " << m << " column " << n;
    }
  }
}

TEST(TwoStage, ModesAreTheRootsOfTheLinearisedValve) {
  // Their sum is the trace of the Jacobian.
  const TwoStagePhysics physics(appendix_a_settling());
  const TwoStageState s = two_stage_at_rest(physics, 250.0 * kInch3_m3);
  double sum = 0.0;
  for (const Mode& mode : modes(physics, s)) sum += (mode.frequency_Hz > 0.0 ? 2.0 : 1.0) * mode.growth_1_s;
  const TwoStagePhysics::Slopes j = physics.slopes(s);
  EXPECT_NEAR(sum, j.P1_P1 + j.P2_P2 + j.v_v + j.u_u, 1e-6 * std::abs(sum));
}

TEST(TwoStage, RefusesWhatCannotBeNamingTheField) {
  TwoStageConfig config = appendix_a_settling();
  config.pilot.mass_kg = 0.0;
  try {
    TwoStagePhysics physics(config);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "two-stage valve pilot mass_kg: 0, expected a finite number above 0");
  }
}

}  // namespace
