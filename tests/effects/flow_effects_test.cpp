// flow_function, supply_droop, exhaust_backpressure, chamber_leak, tube_dynamics against closed forms and balances.
#include <gtest/gtest.h>

#include <numbers>

#include "host-sim/plant/orifice.hpp"
#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

constexpr double kGain_m2_V = 1e-6;
constexpr double kSupply_Pa = 700000.0;
constexpr double kAmbient_Pa = 101325.0;

double choked_s_m() {
  const Surroundings around;
  return plant::thin_plate_constants(around.gas, around.discharge_coefficient).beta_s_m;
}

// ---- flow_function

/// Flow through the inlet, one volt open, at a pressure ratio, over the choked flow of the thin plate.
double psi(EffectSet on, const Figures& figures, double ratio) {
  return flow_kg_s(on, figures, 6.0, ratio * kSupply_Pa) / (kGain_m2_V * choked_s_m() * kSupply_Pa);
}

double psi_of(double critical_ratio, double index, double cracking_ratio, double slope, double ratio) {
  return psi(only(kIdFlowFunction),
             with(sharp_valve(kGain_m2_V), kIdFlowFunction, {critical_ratio, index, cracking_ratio, slope}),
             ratio);
}

TEST(FlowFunction, OfTheThinPlateIsThatOfThePlantsOrifice) {
  const Surroundings around;
  const plant::ThinPlate plate(plant::thin_plate_constants(around.gas, around.discharge_coefficient));
  for (const double ratio : {0.2, 0.5, 0.53, 0.6, 0.8, 0.95, 0.999}) {
    const double plain = psi(0, sharp_valve(kGain_m2_V), ratio);
    EXPECT_NEAR(plain, plate.phi(kSupply_Pa, ratio * kSupply_Pa) / (choked_s_m() * kSupply_Pa), 1e-5)
        << "at ratio " << ratio;
    EXPECT_NEAR(psi_of(kThinPlateCritical, 0.5, 1.0, 0.0, ratio), plain, 1e-8) << "at ratio " << ratio;
  }
}

TEST(FlowFunction, IsChokedBelowTheCriticalRatioAndShutAboveTheCrackingRatio) {
  for (const double b : {0.2, 0.45, 0.7}) {
    EXPECT_NEAR(psi_of(b, 0.5, 0.9, 0.0, 0.15), 1.0, 1e-6);
    EXPECT_NEAR(psi_of(b, 0.5, 0.9, 0.0, b - 1e-3), 1.0, 1e-6) << "just below " << b;
    EXPECT_LT(psi_of(b, 0.5, 0.9, 0.0, b + 0.05), 1.0 - 1e-3) << "above " << b;
    EXPECT_GT(psi_of(b, 0.5, 0.9, 0.0, 0.89), 0.1);
    EXPECT_EQ(psi_of(b, 0.5, 0.9, 0.0, 0.91), 0.0);
  }
}

TEST(FlowFunction, ExhaustHasACriticalRatioOfItsOwn) {
  // a chamber that vents to ambient, at the ratio Q/p
  const auto vented = [](double critical_ratio, double more, double ratio) {
    const Figures figures =
        with(sharp_valve(kGain_m2_V), kIdFlowFunction, {critical_ratio, 0.5, 1.0, 0.0, more});
    return flow_kg_s(only(kIdFlowFunction), figures, 4.0, kAmbient_Pa / ratio);
  };
  for (const double ratio : {0.3, 0.45, 0.6, 0.9}) {
    EXPECT_NEAR(vented(0.3, 0.2, ratio) / vented(0.5, 0.0, ratio), 1.0, 1e-12) << "at ratio " << ratio;
    EXPECT_NEAR(psi(only(kIdFlowFunction),
                    with(sharp_valve(kGain_m2_V), kIdFlowFunction, {0.3, 0.5, 1.0, 0.0, 0.2}), ratio),
                psi_of(0.3, 0.5, 1.0, 0.0, ratio), 1e-12)
        << "of the inlet, at ratio " << ratio;
  }
  // the ellipse's, to half a percent: sqrt(1 - (0.1/0.5)^2) over sqrt(1 - (0.3/0.7)^2)
  EXPECT_NEAR(vented(0.3, 0.2, 0.6) / vented(0.3, 0.0, 0.6), 1.0844, 0.01);
}

TEST(FlowFunction, IsWithinHalfAPercentOfTheEllipseOfIso6358) {
  for (const double b : {0.25, 0.4, 0.528}) {
    for (const double a : {0.92, 1.0}) {
      for (double ratio = b; ratio < a - 0.03; ratio += 0.01) {
        const double x = (ratio - b) / (a - b);
        EXPECT_NEAR(psi_of(b, 0.5, a, 0.0, ratio), std::sqrt(1.0 - x * x), 0.005)
            << "at ratio " << ratio << " b " << b << " a " << a;
      }
    }
  }
}

TEST(FlowFunction, SubsonicIndexIsAPowerOfTheShareThatPasses) {
  for (const double ratio : {0.6, 0.75, 0.9, 0.97}) {
    const double plain = psi_of(0.4, 0.5, 1.0, 0.0, ratio);
    for (const double index : {0.3, 0.8, 1.2}) {
      EXPECT_NEAR(psi_of(0.4, index, 1.0, 0.0, ratio), std::pow(plain, 2.0 * index), 1e-4)
          << "at ratio " << ratio << " index " << index;
    }
  }
}

TEST(FlowFunction, DischargeSlopeIsLinearInTheRatioOnBothSidesOfTheCriticalOne) {
  for (const double ratio : {0.1, 0.4, 0.528, 0.7, 0.95}) {
    EXPECT_NEAR(
        psi_of(kThinPlateCritical, 0.5, 1.0, 0.6, ratio) / psi_of(kThinPlateCritical, 0.5, 1.0, 0.0, ratio),
        1.0 + 0.6 * (kThinPlateCritical - ratio), 1e-5)
        << "at ratio " << ratio;
  }
}

// ---- supply_droop

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

// ---- exhaust_backpressure

ExhaustBackpressure<double> silencer_of(double resistance_kPa_s_per_g, double manifold_mL, double step_s,
                                        double straight_share = 0.0, double standing_kPa = 0.0,
                                        double critical_ratio = 0.0) {
  const double x[] = {resistance_kPa_s_per_g, manifold_mL, straight_share, standing_kPa, critical_ratio};
  ExhaustBackpressure<double> silencer;
  silencer.prepare(x, RT(), 1.4, step_s, kAmbient_Pa);
  return silencer;
}

struct Vented {
  double flow, by_downstream;
};

TEST(ExhaustBackpressure, WithoutAManifoldTheMiddleOfAStepIsTheSilencersOwnPressure) {
  const ExhaustBackpressure<double> silencer = silencer_of(40.0, 0.0, 0.0025);
  const auto steady = [](double, double) { return Vented{2e-3, 0.0}; };
  EXPECT_NEAR(silencer.behind_at_middle_Pa(6e5, 0.0, steady), std::hypot(kAmbient_Pa, 80e3), 1e-6) << "Pa";
  // the flow is 2 g/s less 1 mg/s for each Pa behind the port: 2 kPa stop it
  const auto stopped = [](double, double behind_Pa) {
    return Vented{2e-3 - 1e-6 * (behind_Pa - kAmbient_Pa), -1e-6};
  };
  const double behind_Pa = silencer.behind_at_middle_Pa(6e5, 0.0, stopped);
  EXPECT_NEAR(std::hypot(kAmbient_Pa, 40e6 * stopped(6e5, behind_Pa).flow), behind_Pa, 1e-3) << "Pa";
}

TEST(ExhaustBackpressure, SteadyPressureBehindThePortIsThatOfTheSilencer) {
  for (const double manifold_mL : {0.0, 5.0, 100.0}) {
    ExhaustBackpressure<double> silencer = silencer_of(40.0, manifold_mL, 0.0025);
    for (int k = 0; k < 4000; ++k) silencer.vent(2e-3);
    EXPECT_NEAR(silencer.behind_Pa(), std::hypot(kAmbient_Pa, 80e3), 1e-3) << "Pa, " << manifold_mL << " mL";
  }
}

TEST(ExhaustBackpressure, OfACriticalRatioTheSilencerObeysIso6358AndChokes) {
  constexpr double kResistance_Pa_s_kg = 80e6;
  for (const double b : {0.2, 0.5, 0.528, 0.7}) {
    int choked = 0;
    for (const double flow_kg_s : {0.2e-3, 1e-3, 1.6e-3, 2e-3, 3e-3, 8e-3}) {
      for (const double manifold_mL : {0.0, 5.0}) {
        ExhaustBackpressure<double> silencer = silencer_of(80.0, manifold_mL, 0.0025, 0.0, 0.0, b);
        for (int k = 0; k < 4000; ++k) silencer.vent(flow_kg_s);
        const double P = silencer.behind_Pa();
        const double ratio = std::max((kAmbient_Pa / P - b) / (1.0 - b), 0.0);
        EXPECT_NEAR(P / kResistance_Pa_s_kg * std::sqrt(1.0 - ratio * ratio), flow_kg_s, 1e-6 * flow_kg_s)
            << "kg/s, b " << b << ", " << P << " Pa, " << manifold_mL << " mL";
        choked += ratio == 0.0;
      }
    }
    EXPECT_GT(choked, 0) << b;
    EXPECT_LT(choked, 12) << b;
  }
}

TEST(ExhaustBackpressure, PressureRisesWithTheFlowAndNeverJumpsAlsoWhereAHalfStraightSilencerChokes) {
  constexpr double kFlow_kg_s = 1e-5, kResistance_Pa_s_kg = 60e6;
  double before_Pa = kAmbient_Pa;
  for (double flow_kg_s = kFlow_kg_s; flow_kg_s < 6e-3; flow_kg_s += kFlow_kg_s) {
    ExhaustBackpressure<double> silencer = silencer_of(60.0, 0.0, 0.0025, 0.4, 0.0, 0.5);
    silencer.vent(flow_kg_s);
    const double rise_Pa = silencer.behind_Pa() - before_Pa;
    EXPECT_GT(rise_Pa, 0.0) << flow_kg_s << " kg/s";
    EXPECT_LT(rise_Pa, 2.5 * kResistance_Pa_s_kg * kFlow_kg_s) << "Pa, at " << flow_kg_s << " kg/s";
    before_Pa = silencer.behind_Pa();
  }
}

TEST(ExhaustBackpressure, ManifoldEmptiesAsAHyperbolicCosine) {
  // P' = -k sqrt(P^2 - P_a^2):  P = P_a cosh(theta - k t), at rest from theta on
  const double manifold_m3 = 100e-6;
  const double k_1_s = 1.4 * RT() / (manifold_m3 * 40e6);
  ExhaustBackpressure<double> silencer = silencer_of(40.0, 100.0, 1e-4);
  for (int k = 0; k < 100000; ++k) silencer.vent(2e-3);
  const double theta = std::acosh(silencer.behind_Pa() / kAmbient_Pa);
  for (int k = 1; k <= 500; ++k) {
    silencer.vent(0.0);
    const double left = std::max(0.0, theta - k_1_s * 1e-4 * k);
    ASSERT_NEAR(silencer.behind_Pa(), kAmbient_Pa * std::cosh(left), 2.0) << "Pa after " << 0.1 * k << " ms";
  }
}

TEST(ExhaustBackpressure, BehindAStraightSilencerPressureIsAmbientAndResistanceTimesFlow) {
  for (const double manifold_mL : {0.0, 100.0}) {
    ExhaustBackpressure<double> silencer = silencer_of(40.0, manifold_mL, 0.0025, 1.0);
    for (int k = 0; k < 4000; ++k) silencer.vent(2e-3);
    EXPECT_NEAR(silencer.behind_Pa(), kAmbient_Pa + 80e3, 1e-3) << "Pa, " << manifold_mL << " mL";
  }
  // half of either: P^2 = P_a^2 + P_a R m + (R m)^2
  ExhaustBackpressure<double> half = silencer_of(40.0, 0.0, 0.0025, 0.5);
  half.vent(2e-3);
  EXPECT_NEAR(half.behind_Pa(), std::sqrt(kAmbient_Pa * (kAmbient_Pa + 80e3) + 80e3 * 80e3), 1e-3) << "Pa";
}

TEST(ExhaustBackpressure, ManifoldBehindAStraightSilencerEmptiesExponentially) {
  const double k_1_s = 1.4 * RT() / (100e-6 * 40e6);
  ExhaustBackpressure<double> silencer = silencer_of(40.0, 100.0, 1e-4, 1.0);
  for (int k = 0; k < 100000; ++k) silencer.vent(2e-3);
  const double above_Pa = silencer.behind_Pa() - kAmbient_Pa;
  for (int k = 1; k <= 500; ++k) {
    silencer.vent(0.0);
    ASSERT_NEAR(silencer.behind_Pa() - kAmbient_Pa, above_Pa * std::exp(-k_1_s * 1e-4 * k), 2.0)
        << "Pa after " << 0.1 * k << " ms";
  }
}

TEST(ExhaustBackpressure, WhatStandsBehindThePortIsThereWithoutFlowAndUnderIt) {
  for (const double manifold_mL : {0.0, 100.0}) {
    const auto behind_Pa = [&](double resistance_kPa_s_per_g, double straight_share, double flow_kg_s) {
      auto silencer = silencer_of(resistance_kPa_s_per_g, manifold_mL, 0.0025, straight_share, 15.0);
      for (int k = 0; k < 4000; ++k) silencer.vent(flow_kg_s);
      return silencer.behind_Pa();
    };
    EXPECT_NEAR(behind_Pa(40.0, 0.0, 0.0), kAmbient_Pa + 15e3, 1e-3) << "Pa, " << manifold_mL << " mL";
    EXPECT_NEAR(behind_Pa(0.0, 0.0, 2e-3), kAmbient_Pa + 15e3, 1e-3) << "Pa, " << manifold_mL << " mL";
    EXPECT_NEAR(behind_Pa(40.0, 0.0, 2e-3), std::hypot(kAmbient_Pa + 15e3, 80e3), 1e-3)
        << "Pa, " << manifold_mL << " mL";
    EXPECT_NEAR(behind_Pa(40.0, 1.0, 2e-3), kAmbient_Pa + 15e3 + 80e3, 1e-3)
        << "Pa, " << manifold_mL << " mL";
  }
}

TEST(ExhaustBackpressure, VentedChamberComesToRestAtWhatStandsBehindThePort) {
  const Figures figures = with(sharp_valve(kGain_m2_V), kIdExhaustBackpressure, {0.0, 0.0, 0.0, 15.0});
  const Drive drive = drive_of(std::vector<double>(400, 3.0), plant::VolumeMotion(100e-6), 4);
  EXPECT_NEAR(run(only(kIdExhaustBackpressure), figures, drive, 3e5).back(), kAmbient_Pa + 15e3, 1.0) << "Pa";
}

TEST(ExhaustBackpressure, ChangesNothingWhileTheExhaustIsChoked) {
  const Figures figures = with(sharp_valve(kGain_m2_V), kIdExhaustBackpressure, {40.0, 5.0});
  const double choked = flow_kg_s(0, sharp_valve(kGain_m2_V), 4.0, 6e5);
  EXPECT_EQ(flow_kg_s(only(kIdExhaustBackpressure), figures, 4.0, 6e5, {}, 20),
            flow_kg_s(0, sharp_valve(kGain_m2_V), 4.0, 6e5, {}, 20));
  EXPECT_LT(40e6 * -choked, 0.528 * 6e5) << "Pa: what the silencer adds leaves the port choked";
}

TEST(ExhaustBackpressure, SubsonicVentIsInEquilibriumWithTheSilencer) {
  const Surroundings around;
  const plant::ThinPlate plate(plant::thin_plate_constants(around.gas, around.discharge_coefficient));
  const Figures figures = with(sharp_valve(kGain_m2_V), kIdExhaustBackpressure, {200.0, 2.0});
  const double vented = -flow_kg_s(only(kIdExhaustBackpressure), figures, 4.0, 1.5e5, {}, 50);
  const double behind_Pa = std::hypot(kAmbient_Pa, 200e6 * vented);
  EXPECT_NEAR(vented / (kGain_m2_V * plate.phi(1.5e5, behind_Pa)), 1.0, 1e-5);
  EXPECT_GT(behind_Pa, kAmbient_Pa + 5e3) << "Pa: enough to be seen";
}

// ---- chamber_leak

TEST(ChamberLeak, SealedChamberDecaysAsTheLaminarLawInClosedForm) {
  // p' = -K (p^2 - P_a^2):  (p - P_a)/(p + P_a) falls as e^(-2 K P_a t)
  const double volume_m3 = 200e-6;
  const double conductance = 0.3;  // g/(s MPa)
  const double K = 1.4 * RT() / volume_m3 * conductance * 1e-9 / (2.0 * kAmbient_Pa);
  const Figures figures = with(sealed(), kIdChamberLeak, {conductance});
  for (const int steps : {4, 16}) {
    Drive drive = drive_of(std::vector<double>(1000, 5.0), plant::VolumeMotion(volume_m3), steps);
    drive.timing.average_s = 0.0;
    const std::vector<double> p = run(only(kIdChamberLeak), figures, drive, 6e5);
    for (std::size_t k = 0; k < p.size(); k += 50) {
      const double c = (6e5 - kAmbient_Pa) / (6e5 + kAmbient_Pa) *
                       std::exp(-2.0 * K * kAmbient_Pa * static_cast<double>(k) * kTick_s);
      EXPECT_NEAR(p[k], kAmbient_Pa * (1.0 + c) / (1.0 - c), steps == 4 ? 0.5 : 0.03)
          << "Pa at row " << k << ", " << steps << " steps";
    }
  }
}

TEST(ChamberLeak, SlopeIsThatOfItsFlow) {
  for (const double density_share : {0.0, 0.4, 1.0}) {
    const double x[] = {2.0, density_share, 0.0, 150.0};
    ChamberLeak<double> leak;
    leak.prepare(x, kAmbient_Pa, 100e-6, 100e-6);
    for (const double p : {5e4, 2e5, 7e5}) {
      EXPECT_NEAR((leak.flow(p + 100.0) - leak.flow(p - 100.0)) / 200.0 / leak.slope(p), 1.0, 1e-9)
          << "at " << p << " Pa, density share " << density_share;
    }
  }
}

TEST(ChamberLeak, StraightInTheGaugePressureASealedChamberDecaysExponentially) {
  const double volume_m3 = 200e-6;
  const double conductance = 0.3;  // g/(s MPa)
  const double per_s = 1.4 * RT() / volume_m3 * conductance * 1e-9;
  const Figures figures = with(sealed(), kIdChamberLeak, {conductance, 0.0});
  Drive drive = drive_of(std::vector<double>(1000, 5.0), plant::VolumeMotion(volume_m3), 4);
  drive.timing.average_s = 0.0;
  const std::vector<double> p = run(only(kIdChamberLeak), figures, drive, 6e5);
  for (std::size_t k = 0; k < p.size(); k += 50) {
    EXPECT_NEAR(p[k] - kAmbient_Pa, (6e5 - kAmbient_Pa) * std::exp(-per_s * static_cast<double>(k) * kTick_s),
                0.01)
        << "Pa at row " << k;
  }
}

TEST(ChamberLeak, GrowsWithThePowerOfTheVolumeAlongAWornBore) {
  const double x[] = {2.0, 1.0, 1.5, 0.0};
  ChamberLeak<double> leak;
  // the conductance is that at the mean volume, wherever a log begins
  const double gauge_Pa = 4e5 - kAmbient_Pa;
  const double mean_kg_s = 2e-9 * gauge_Pa * (1.0 + gauge_Pa / (2.0 * kAmbient_Pa));
  leak.prepare(x, kAmbient_Pa, 100e-6, 250e-6);
  EXPECT_NEAR(leak.flow(4e5) / mean_kg_s, std::pow(2.5, 1.5), 1e-6);
  for (const double share : {0.5, 1.0, 3.0}) {
    leak.at(share * 100e-6);
    EXPECT_NEAR(leak.flow(4e5) / mean_kg_s, std::pow(share, 1.5), 1e-6) << share;
  }
}

TEST(ChamberLeak, PastAPistonASealedChamberComesToThePressureOfTheOtherSide) {
  // p' = -K (p^2 - P^2):  (p - P)/(p + P) falls as e^(-2 K P t), from above and from below
  const double volume_m3 = 200e-6, beyond_Pa = kAmbient_Pa + 250e3;
  const double conductance = 0.3;  // g/(s MPa)
  const double K = 1.4 * RT() / volume_m3 * conductance * 1e-9 / (2.0 * beyond_Pa);
  const Figures figures = with(sealed(), kIdChamberLeak, {conductance, 1.0, 0.0, 250.0});
  Drive drive = drive_of(std::vector<double>(1000, 5.0), plant::VolumeMotion(volume_m3), 4);
  drive.timing.average_s = 0.0;
  for (const double start_Pa : {6e5, 1.5e5}) {
    const std::vector<double> p = run(only(kIdChamberLeak), figures, drive, start_Pa);
    for (std::size_t k = 0; k < p.size(); k += 50) {
      const double c = (start_Pa - beyond_Pa) / (start_Pa + beyond_Pa) *
                       std::exp(-2.0 * K * beyond_Pa * static_cast<double>(k) * kTick_s);
      EXPECT_NEAR(p[k], beyond_Pa * (1.0 + c) / (1.0 - c), 0.5) << "Pa at row " << k << " from " << start_Pa;
    }
  }
}

TEST(ChamberLeak, FillsAChamberBelowAmbient) {
  const Figures figures = with(sealed(), kIdChamberLeak, {1.0});
  EXPECT_GT(flow_kg_s(only(kIdChamberLeak), figures, 5.0, 8e4), 0.0);
  EXPECT_NEAR(flow_kg_s(only(kIdChamberLeak), figures, 5.0, kAmbient_Pa), 0.0, 1e-15);
  const double expected_kg_s = -1e-9 * (3e5 * 3e5 - kAmbient_Pa * kAmbient_Pa) / (2.0 * kAmbient_Pa);
  EXPECT_NEAR(flow_kg_s(only(kIdChamberLeak), figures, 5.0, 3e5) / expected_kg_s, 1.0, 1e-5);
}

// ---- tube_dynamics

struct Valve {
  double rate, slope;
};

struct Line {
  double fittings_mm2 = kInfinity, resistance_kPa_s_per_g = 0.0, sensor_share = 0.0;
};
TubeDynamics<double> tube_of(double length_m, double bore_mm, double step_s, double start_Pa,
                             const Line& line = {}) {
  const double x[] = {length_m, bore_mm, 1.0 / (line.fittings_mm2 * line.fittings_mm2),
                      line.resistance_kPa_s_per_g, line.sensor_share};
  TubeDynamics<double> tube;
  tube.prepare(x, RT(), 1.4, step_s, start_Pa);
  return tube;
}

double hose_volume_m3(double length_m, double bore_mm) {
  return std::numbers::pi / 4.0 * bore_mm * bore_mm * 1e-6 * length_m;
}

constexpr TubeDynamics<double>::Ends kEnds{1e5, 6e5};

TEST(TubeDynamics, WhatTheValvePassesIsFoundInHoseAndChamber) {
  const double flow = 2e-3;
  const double per_flow = 1.4 * RT() / 150e-6;
  for (const double length_m : {0.01, 1.0, 8.0}) {
    TubeDynamics<double> tube = tube_of(length_m, 4.0, 0.0025, 2e5);
    const double hose_m3 = hose_volume_m3(length_m, 4.0);
    double chamber_Pa = 2e5;
    for (int k = 1; k <= 100; ++k) {
      double passed = 0.0;
      const auto valve = [&](double, double share) {
        passed += share * flow;
        return Valve{flow, 0.0};
      };
      chamber_Pa = tube.advance(chamber_Pa, {per_flow, 0.0, 0.0}, kEnds, valve).end_Pa;
      ASSERT_NEAR(passed / flow, 1.0, 1e-12) << "the shares of a step's mean";
      const double gained_kg =
          ((chamber_Pa - 2e5) * 150e-6 + (tube.at_valve_Pa() - 2e5) * hose_m3) / (1.4 * RT());
      ASSERT_NEAR(gained_kg / (flow * 0.0025 * k), 1.0, 1e-9) << "step " << k << ", " << length_m << " m";
    }
  }
}

TEST(TubeDynamics, SteadyDropIsThatOfIsothermalFlowWithLaminarPlusTurbulentFriction) {
  const double flow = 1e-3;
  const double length_m = 2.0;
  const double bore_m = 4e-3;
  TubeDynamics<double> tube = tube_of(length_m, 4.0, 0.0025, 3e5);
  // a chamber without end: its pressure stands still
  for (int k = 0; k < 4000; ++k) {
    tube.advance(3e5, {0.0, 0.0, 0.0}, kEnds, [&](double, double) { return Valve{flow, 0.0}; });
  }
  // p dp = -R T (128 mu w/(pi D^4) + f w^2/(2 D A^2)) dx, from one end to the other
  const double area = std::numbers::pi / 4.0 * bore_m * bore_m;
  const double per_m = 128.0 * 1.8e-5 * flow / (std::numbers::pi * std::pow(bore_m, 4)) +
                       0.03 * flow * flow / (2.0 * bore_m * area * area);
  const double expected_Pa = std::sqrt(3e5 * 3e5 + 2.0 * RT() * per_m * length_m);
  EXPECT_NEAR(tube.flow_kg_s() / flow, 1.0, 1e-9);
  EXPECT_NEAR(tube.at_valve_Pa() / expected_Pa, 1.0, 1e-9);
}

/// At the valve, a steady flow going through a wide hose into a chamber without end at 300 kPa.
double steady_Pa(const Line& line, double flow_kg_s) {
  TubeDynamics<double> tube = tube_of(1e-3, 12.0, 0.0025, 3e5, line);
  for (int k = 0; k < 4000; ++k) {
    tube.advance(3e5, {0.0, 0.0, 0.0}, kEnds, [&](double, double) { return Valve{flow_kg_s, 0.0}; });
  }
  return tube.at_valve_Pa();
}

TEST(TubeDynamics, FilterDropsItsResistanceTimesTheFlowAndFittingsAsAnOrificeDoes) {
  const double none_Pa = steady_Pa({}, 1e-3);
  EXPECT_NEAR(steady_Pa({.resistance_kPa_s_per_g = 40.0}, 1e-3) - none_Pa, 40e3, 1.0) << "Pa";
  EXPECT_NEAR(steady_Pa({.resistance_kPa_s_per_g = 40.0}, 2e-3) - steady_Pa({}, 2e-3), 80e3, 2.0) << "Pa";
  // p_t^2 - p^2 = R T (w/a)^2
  const double through_Pa = std::sqrt(RT()) * 1e-3 / 3e-6;
  EXPECT_NEAR(steady_Pa({.fittings_mm2 = 3.0}, 1e-3) / std::sqrt(none_Pa * none_Pa + through_Pa * through_Pa),
              1.0, 1e-6);
}

TEST(TubeDynamics, SensorAtTheValveReadsWhatStandsThereAndHalfwayTheMiddle) {
  const std::vector<double> command_V = jumping_command_V(300);
  const auto reading = [&](double share, int steps) {
    Figures figures = with(nominal(), kIdTubeDynamics, {1.5, 4.0, kInfinity, 0.0, share});
    return run(only(kIdTubeDynamics), figures, drive_of(command_V, swinging_volume(), steps), 3e5);
  };
  const std::vector<double> chamber = reading(0.0, 64), halfway = reading(0.5, 64), valve = reading(1.0, 64);
  EXPECT_GT(rms_difference(chamber, valve), 5e3) << "Pa";
  for (std::size_t k = 0; k < valve.size(); ++k) {
    ASSERT_NEAR(halfway[k], 0.5 * (chamber[k] + valve[k]), 1e-6) << "Pa, row " << k;
  }
  EXPECT_LT(rms_difference(reading(1.0, 4), reading(1.0, 256)), 250.0) << "Pa";

  // at the end of each step, too
  TubeDynamics<double> tube = tube_of(1.5, 4.0, 0.0025, 3e5, {.sensor_share = 1.0});
  for (int k = 0; k < 10; ++k) {
    const auto step = tube.advance(3e5, {0.0, 0.0, 0.0}, kEnds, [](double, double) {
      return Valve{1e-3, 0.0};
    });
    EXPECT_EQ(tube.read_Pa(step.end_Pa), tube.at_valve_Pa());
  }
}

TEST(TubeDynamics, ShutHoseSwingsAtTheFrequencyOfItsLump) {
  const double length_m = 1.0;
  const double step_s = 2e-5;
  TubeDynamics<double> tube = tube_of(length_m, 12.0, step_s, 3e5);
  // pushed off by 100 Pa: friction is laminar, and little in so wide a hose
  double before = 0.0;
  std::vector<double> crossings_s;
  for (int k = 1; k < 20000 && crossings_s.size() < 9; ++k) {
    tube.advance(3e5 - 100.0, {0.0, 0.0, 0.0}, kEnds, [](double, double) { return Valve{0.0, 0.0}; });
    if (k > 1 && before * tube.flow_kg_s() < 0.0) crossings_s.push_back(k * step_s);
    before = tube.flow_kg_s();
  }
  ASSERT_EQ(crossings_s.size(), 9U);
  const double frequency_Hz = 4.0 / (crossings_s[8] - crossings_s[0]);
  const double sound_m_s = std::sqrt(1.4 * RT());
  EXPECT_NEAR(frequency_Hz / (sound_m_s / (2.0 * std::numbers::pi * length_m)), 1.0, 0.01) << "Hz";
}

TEST(TubeDynamics, RestingHoseAddsItsAirToTheChamber) {
  // slow changes: the chamber is larger by the hose
  const double length_m = 0.5, bore_mm = 8.0;
  const Figures figures = with(sharp_valve(1e-12), kIdTubeDynamics, {length_m, bore_mm});
  const Drive drive = drive_of(std::vector<double>(400, 6.0), plant::VolumeMotion(100e-6), 4);
  const std::vector<double> with_hose = run(only(kIdTubeDynamics), figures, drive, 1.2e5);
  const std::vector<double> without = run(0, sharp_valve(1e-12), drive, 1.2e5);
  EXPECT_GT(without.back() - 1.2e5, 1.0) << "Pa";
  EXPECT_NEAR((without.back() - 1.2e5) / (with_hose.back() - 1.2e5),
              1.0 + hose_volume_m3(length_m, bore_mm) / 100e-6, 1e-2);
}

TEST(TubeDynamics, VeryShortHoseIsAsNone) {
  const std::vector<double> command_V = jumping_command_V(1000);
  const Drive drive = drive_of(command_V, swinging_volume(), 32);
  const std::vector<double> plain = run(0, nominal(), drive, 3e5);
  EXPECT_LT(rms_difference(
                run(only(kIdTubeDynamics), with(nominal(), kIdTubeDynamics, {0.0, 4.0}), drive, 3e5), plain),
            25.0)
      << "Pa: the friction of a millimetre, in swings of 600 kPa";
}

TEST(TubeDynamics, HoseOfAnyLengthAndBoreIsTheSameAtFourStepsAsAtManyMore) {
  const std::vector<double> command_V = jumping_command_V(300);
  struct Behind {
    plant::VolumeMotion chamber;
    double gain_m2_V;
  };
  const Behind usual{swinging_volume(), 1.5e-6};
  // the valve fills a hose of 2 mm to the supply within half a millisecond
  const Behind small{
      plant::VolumeMotion(45e-6, {{{.amplitude_m3 = 8e-6, .frequency_Hz = 0.9, .phase_rad = 0.3}, {}, {}}}),
      4e-6};
  for (const Behind& machine : {usual, small}) {
    for (const double length_m : {0.0, 0.03, 0.11, 0.3, 1.0, 5.0}) {
      for (const double bore_mm : {2.0, 4.0, 8.0}) {
        Figures figures = with(nominal(), kIdTubeDynamics, {length_m, bore_mm});
        figures[kInletGain] = figures[kExhaustGain] = machine.gain_m2_V;
        const auto at = [&](int steps) {
          return run(only(kIdTubeDynamics), figures, drive_of(command_V, machine.chamber, steps), 3e5);
        };
        const std::vector<double> fine = at(256);
        EXPECT_LT(rms_difference(at(4), fine), 250.0) << "Pa, " << length_m << " m of " << bore_mm << " mm";
        EXPECT_LT(rms_difference(at(64), fine), 50.0) << "Pa, " << length_m << " m of " << bore_mm << " mm";
      }
    }
  }
}

}  // namespace
}  // namespace plenum::host::effects
