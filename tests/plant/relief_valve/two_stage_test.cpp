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

// The source's force balances with its numbers, in its own units: pounds force, inches, seconds.
TEST(TwoStage, ForcesAreThoseOfThePrintedBalances) {
  const TwoStagePhysics physics(appendix_a_as_printed());
  const double P1 = kSomewhere[kP1] / kPsi_Pa;
  const double P2 = kSomewhere[kP2] / kPsi_Pa;
  const double x = kSomewhere[kX] / kInch_m;
  const double y = kSomewhere[kY] / kInch_m;
  const double pi = std::numbers::pi;
  const double rho = 60.0 / 1728.0 / 386.0886;  // lbf s2/in4
  const double mu = 10e-6 / (0.0254 * 0.0254) * rho;
  const double m = 67.0 * pi / 180.0;
  const double p = 17.0 * pi / 180.0;
  const double main_flow_force =
      P1 * 0.8 * pi * 0.5 * x * (std::sin(2 * m) / 2 - 4 * 0.8 * x * std::pow(std::sin(m), 2) / 0.5);
  const double main_drag =
      mu * (pi * 1.5) / 0.004 + 1.0 * pi * 0.5 * std::sin(m) * 0.8 * std::sqrt(2 * rho * P1);
  const double main =
      1.436 * (P1 - P2) - 100.0 * (x + 1.0) - main_flow_force - main_drag * kSomewhere[kV] / kInch_m;
  EXPECT_NEAR(physics.main_force_N(kSomewhere) / kPoundForce_N, main, 1e-5 * 100.0) << "lbf";
  const double pilot_flow_force =
      P2 * 0.75 * pi * 0.2 * y * (std::sin(2 * p) / 2 - 4 * 0.75 * y * std::pow(std::sin(p), 2) / 0.2);
  const double pilot_drag = 0.1 * pi * 0.2 * std::sin(p) * 0.75 * std::sqrt(2 * rho * P2);
  const double pilot =
      pi / 4 * 0.04 * P2 - 100.0 * (y + 0.2) - pilot_flow_force - pilot_drag * kSomewhere[kU] / kInch_m;
  EXPECT_NEAR(physics.pilot_force_N(kSomewhere) / kPoundForce_N, pilot, 1e-5 * 20.0) << "lbf";
  EXPECT_NEAR(physics.main_flow_m3_s(kSomewhere[kP1], kSomewhere[kX]) / kInch3_m3,
              0.8 * pi * 0.5 * x * std::sin(m) * std::sqrt(2 * P1 / rho), 1e-3)
      << "in3/s";
  EXPECT_NEAR(physics.capillary_flow_m3_s(kSomewhere[kP1], kSomewhere[kP2]) / kInch3_m3,
              pi * 1e-8 / (128 * mu * 0.45) * (P1 - P2), 1e-6)
      << "in3/s";
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

TEST(TwoStage, SettlingValveIsStableNear130HzAtEveryFlowAndThePrintedOneAtNone) {
  const TwoStagePhysics settling(appendix_a_settling());
  const TwoStagePhysics printed(appendix_a_as_printed());
  for (double flow_in3_s = 10.0; flow_in3_s <= 300.0; flow_in3_s += 10.0) {
    const Mode mode = modes(settling, two_stage_at_rest(settling, flow_in3_s * kInch3_m3)).front();
    EXPECT_LT(mode.growth_1_s, -30.0) << flow_in3_s << " in3/s";
    EXPECT_NEAR(mode.frequency_Hz, 130.0, 2.0) << flow_in3_s << " in3/s";
    EXPECT_GT(modes(printed, two_stage_at_rest(printed, flow_in3_s * kInch3_m3)).front().growth_1_s, 100.0)
        << flow_in3_s << " in3/s";
  }
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
