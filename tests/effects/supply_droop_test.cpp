// supply_droop against closed forms and balances.
#include <gtest/gtest.h>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

SupplyDroop<double> source(double resistance_kPa_s_per_g, double recovery_s, double orifice_share,
                           double step_s = 0.0025, double relieving_share = 1.0,
                           double followed_share = 0.0) {
  const double x[] = {resistance_kPa_s_per_g, recovery_s, orifice_share, relieving_share, followed_share};
  SupplyDroop<double> droop;
  droop.prepare(x, step_s, kSupply_Pa);
  return droop;
}

TEST(SupplyDroop, FollowsItsShareOfWhatTheLogSays) {
  for (const double share : {0.0, 0.5, 1.0}) {
    SupplyDroop<double> droop = source(0.0, 0.005, 0.0, 0.0025, 1.0, share);
    for (int k = 0; k < 40; ++k) {
      droop.follow(kSupply_Pa - 30e3);
      droop.draw(1e-3);
    }
    EXPECT_NEAR(droop.supply_Pa(), kSupply_Pa - share * 30e3, 1.0) << "Pa, share " << share;
  }
  SupplyDroop<double> slow = source(0.0, 1.0, 0.0, 0.0025, 1.0, 1.0);
  slow.follow(kSupply_Pa - 50e3);
  EXPECT_EQ(slow.supply_Pa(), kSupply_Pa - 50e3) << "Pa: it begins where the log does";
  for (const double to_Pa : {kSupply_Pa, kSupply_Pa - 90e3}) {  // up and down, by 1 - 1/e in a time constant
    const double from_Pa = slow.supply_Pa();
    for (int k = 0; k < 400; ++k) {
      slow.follow(to_Pa);
      slow.draw(1e-3);
    }
    EXPECT_NEAR(slow.supply_Pa(), to_Pa + (from_Pa - to_Pa) * std::exp(-1.0), 10.0) << "Pa";
  }
  SupplyDroop<double> both = source(20.0, 0.005, 0.0, 0.0025, 1.0, 1.0);
  for (int k = 0; k < 40; ++k) {
    both.follow(kSupply_Pa - 30e3);
    both.draw(1e-3);
  }
  EXPECT_NEAR(both.supply_Pa(), kSupply_Pa - 50e3, 1.0) << "Pa: what is drawn here comes on top";
}

TEST(SupplyDroop, SteadyDroopOfARegulatorIsResistanceTimesFlow) {
  SupplyDroop<double> droop = source(20.0, 0.1, 0.0);  // 20 kPa for a gram a second
  for (int k = 0; k < 2000; ++k) droop.draw(3e-3);
  EXPECT_NEAR(droop.supply_Pa(), kSupply_Pa - 60e3, 1e-6) << "Pa";
}

TEST(SupplyDroop, RecoveryOfARegulatorIsExponentialToTheSecondOrder) {
  const auto error_Pa = [](double step_s) {
    SupplyDroop<double> droop = source(20.0, 0.1, 0.0, step_s);
    for (int k = 0; k < 20000; ++k) droop.draw(3e-3);
    double worst = 0.0;
    for (int k = 1; k * step_s <= 0.5; ++k) {
      droop.draw(0.0);
      worst = std::max(worst, std::abs(droop.supply_Pa() - kSupply_Pa + 60e3 * std::exp(-step_s * k / 0.1)));
    }
    return worst;
  };
  EXPECT_LT(error_Pa(0.0025), 5.0) << "Pa";
  EXPECT_NEAR(error_Pa(0.0025) / error_Pa(0.000625), 16.0, 1.0);
}

TEST(SupplyDroop, SteadyFlowThroughAnOrificeIsTheRootOfItsDroop) {
  SupplyDroop<double> droop = source(20.0, 0.1, 1.0);
  for (int k = 0; k < 4000; ++k) droop.draw(2e-3);
  const double supply_Pa = droop.supply_Pa();
  EXPECT_NEAR((kSupply_Pa * kSupply_Pa - supply_Pa * supply_Pa) / (20.0 * 40e3 * 40e3), 1.0, 1e-9);
}

TEST(SupplyDroop, AirPushedBackRaisesTheSupplyByTheSameLaw) {
  for (const double share : {0.0, 0.5, 1.0}) {
    SupplyDroop<double> droop = source(20.0, 0.1, share);
    for (int k = 0; k < 4000; ++k) droop.draw(-2e-3);
    const double through_Pa = droop.supply_Pa() - (1.0 - share) * 40e3;
    EXPECT_NEAR((through_Pa * through_Pa - kSupply_Pa * kSupply_Pa) / 1e9, 20.0 * share * 1.6, 1e-6)
        << "1e9 Pa^2, orifice share " << share;
  }
}

TEST(SupplyDroop, SourceThatLetsNothingOutKeepsWhatIsPushedBack) {
  for (const double orifice_share : {0.0, 1.0}) {
    SupplyDroop<double> droop = source(20.0, 0.1, orifice_share, 0.0025, 0.0);
    for (int k = 0; k < 20; ++k) droop.draw(-2e-3);
    const double kept_Pa = 20e6 / 0.1 * 2e-3 * 20 * 0.0025;  // R m t/tau
    EXPECT_NEAR(droop.supply_Pa(), kSupply_Pa + kept_Pa, 1e-3) << "Pa, orifice share " << orifice_share;
    for (int k = 0; k < 20; ++k) droop.draw(0.0);
    EXPECT_NEAR(droop.supply_Pa(), kSupply_Pa + kept_Pa, 1e-3) << "Pa, orifice share " << orifice_share;
    for (int k = 0; k < 2000; ++k) droop.draw(1e-3);
    EXPECT_LT(droop.supply_Pa(), kSupply_Pa) << "Pa: it feeds as before";
  }
}

TEST(SupplyDroop, ChokedFillSettlesAtTheFlowOfTheDroopingSupply) {
  // m = a beta (P - R m)
  for (const double resistance_kPa_s_per_g : {0.0, 5.0, 50.0, 300.0}) {
    const double a_beta = kGain_m2_V * choked_s_m();
    const double expected = a_beta * kSupply_Pa / (1.0 + 1e6 * resistance_kPa_s_per_g * a_beta);
    const Figures figures = with(sharp_valve(kGain_m2_V), kIdSupplyDroop, {resistance_kPa_s_per_g, 0.01});
    EXPECT_NEAR(flow_kg_s(only(kIdSupplyDroop), figures, 6.0, 1.2e5, {}, 50) / expected, 1.0, 1e-6)
        << "of kg/s, " << resistance_kPa_s_per_g << " kPa s/g";
  }
}

TEST(SupplyDroop, SupplyKeepsAFifthOfItself) {
  for (const double share : {0.0, 0.7, 1.0}) {
    SupplyDroop<double> droop = source(400.0, 0.005, share);
    for (int k = 0; k < 100; ++k) droop.draw(1.0);
    EXPECT_DOUBLE_EQ(droop.supply_Pa(), 0.2 * kSupply_Pa) << share;
  }
}

TEST(SupplyDroop, MiddleOfAStepIsAnImplicitHalfAndHoldsAFlowThatAnyDroopStops) {
  const SupplyDroop<double> droop = source(20.0, 0.005, 0.0);
  const double half = 0.00125 / 0.005;
  EXPECT_NEAR(droop.supply_at_middle_Pa(3e-3, 0.0), kSupply_Pa - 60e3 * half / (1.0 + half), 1e-6) << "Pa";
  // the flow is 3 g/s less 1 mg/s for each Pa of droop: 3 kPa stop it
  EXPECT_GT(droop.supply_at_middle_Pa(3e-3, 1e-6), kSupply_Pa - 3e3) << "Pa";
}

}  // namespace
}  // namespace plenum::host::effects
