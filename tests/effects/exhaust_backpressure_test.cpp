// exhaust_backpressure against closed forms and balances.
#include <gtest/gtest.h>

#include "host-sim/plant/orifice.hpp"
#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

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

}  // namespace
}  // namespace plenum::host::effects
