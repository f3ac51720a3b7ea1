#include "host-sim/plant/valve.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host-sim/plant/reach.hpp"

namespace plenum::host::plant {
namespace {

constexpr double kSupply_Pa = 700e3;
constexpr double kAmbient_Pa = 101325.0;

struct Sums {
  double weighted_area = 0.0, b = 0.0, a = 0.0, beta = 0.0;
};
Sums sums(const MpyeTable& table) {
  Sums s;
  double row = 0.0;
  for (const MpyeRow& r : table) {
    s.weighted_area += ++row * r.area_m2;
    s.b += r.critical_ratio;
    s.a += r.cracking_ratio;
    s.beta += r.subsonic_index;
  }
  return s;
}

TEST(MpyeTables, SumToThePrintedTables) {
  // sums over the printed tables, made apart from the transcription; areas weighted by row, so that order
  // counts
  const struct {
    const MpyeTable& table;
    Sums printed;
  } cases[] = {{kMpyeChannelAInlet, {0.0264534, 23.597, 50.24, 27.366}},
               {kMpyeChannelAExhaust, {0.00947745, 19.032, 48.157, 38.464}},
               {kMpyeChannelBInlet, {0.00643582, 23.096, 50.422, 26.786}},
               {kMpyeChannelBExhaust, {0.0464802, 13.9851, 47.156, 38.5}}};
  for (const auto& c : cases) {
    const Sums s = sums(c.table);
    EXPECT_NEAR(s.weighted_area / c.printed.weighted_area, 1.0, 5e-6);
    EXPECT_NEAR(s.b, c.printed.b, 1e-4);
    EXPECT_NEAR(s.a, c.printed.a, 1e-6);
    EXPECT_NEAR(s.beta, c.printed.beta, 1e-6);
  }
}

TEST(MpyeTables, SpotRowsAreAsPrinted) {
  EXPECT_EQ(kMpyeChannelAInlet[34].area_m2, 2.03e-5);           // 6.8 V
  EXPECT_EQ(kMpyeChannelAInlet[29].subsonic_index, 0.721);      // 5.8 V
  EXPECT_EQ(kMpyeChannelAExhaust[25].cracking_ratio, 0.187);    // 5.0 V
  EXPECT_EQ(kMpyeChannelBInlet[13].subsonic_index, 0.546);      // 2.6 V, printed ".546"
  EXPECT_EQ(kMpyeChannelBExhaust[50].critical_ratio, 5.71e-2);  // 10 V
}

TEST(MpyeValve, FlowAtARowIsThatOfEquationFour) {
  const MpyeValve valve(MpyeChannel::a);
  const Gas gas = reference_atmosphere();
  const double RT = gas.specific_gas_constant_J_kg_K() * gas.temperature_K;
  const PortFlows m = valve.flows(valve.opening(8.0), 200e3, kSupply_Pa, kAmbient_Pa);
  EXPECT_NEAR(m.inlet_kg_s / (3.25e-5 * 0.575 * 0.4842 * kSupply_Pa * std::sqrt(2.0 / RT)), 1.0, 1e-4);
  EXPECT_EQ(m.exhaust_kg_s, 0.0);
}

TEST(MpyeValve, InterpolatesLinearlyBetweenRows) {
  const MpyeValve valve(MpyeChannel::a);
  const auto lo = valve.opening(6.4);
  const auto hi = valve.opening(6.6);
  const auto mid = valve.opening(6.45);
  EXPECT_NEAR(mid.inlet.choked_kg_s_Pa, 0.75 * lo.inlet.choked_kg_s_Pa + 0.25 * hi.inlet.choked_kg_s_Pa,
              1e-20);
  EXPECT_NEAR(mid.inlet.critical_ratio, 0.75 * 0.421 + 0.25 * 0.405, 1e-12);
}

TEST(MpyeValve, AreaClosesAtConstantShapeNextToRowsThatWereNotMeasured) {
  const MpyeValve valve(MpyeChannel::a);
  const auto half = valve.opening(5.1);
  EXPECT_NEAR(half.exhaust.cracking_ratio, 0.187, 1e-12);
  EXPECT_NEAR(half.exhaust.choked_kg_s_Pa, 0.5 * valve.opening(5.0).exhaust.choked_kg_s_Pa, 1e-20);
  // p with ambient/p = 0.3: no row conducts there, and neither does anything between
  EXPECT_EQ(valve.flows(half, kAmbient_Pa / 0.3, kSupply_Pa, kAmbient_Pa).exhaust_kg_s, 0.0);
}

TEST(MpyeValve, CommandIsHeldAtTheEndsOfTheTables) {
  const MpyeValve valve(MpyeChannel::b_mirrored);
  EXPECT_EQ(valve.opening(12.0).inlet.choked_kg_s_Pa, valve.opening(10.0).inlet.choked_kg_s_Pa);
  EXPECT_EQ(valve.opening(-3.0).exhaust.choked_kg_s_Pa, valve.opening(0.0).exhaust.choked_kg_s_Pa);
}

TEST(MpyeValve, MirroredChannelFillsAboveAndVentsBelowFiveVolts) {
  const Valve valve = MpyeValve(MpyeChannel::b_mirrored);
  EXPECT_GT(mass_flow_kg_s(valve, 300e3, 7.0, kSupply_Pa, kAmbient_Pa), 1e-3);
  EXPECT_LT(mass_flow_kg_s(valve, 300e3, 3.0, kSupply_Pa, kAmbient_Pa), -1e-3);
}

TEST(ThinPlateValve, AreasAreThePaperFormAtUnitTransition) {
  ThinPlateValveConfig c;
  c.transition_m2 = 1e-6;  // the paper's form with mm2 as its unit of area
  const ThinPlateValve valve(c);
  const auto smax = [](double x) { return 0.5 * (std::sqrt(x * x + 1.0) + x); };
  for (double u = 2.0; u < 8.0; u += 0.37) {
    EXPECT_NEAR(valve.opening(u).inlet_m2 * 1e6, 0.03 + smax((u - 5.08) * 1.5 - 0.03), 1e-12) << u << " V";
    EXPECT_NEAR(valve.opening(u).exhaust_m2 * 1e6, 0.03 + smax((4.92 - u) * 1.6 - 0.03), 1e-12) << u << " V";
  }
}

TEST(TwoPortChamber, FlowFallsWithPressureAndRisesWithCommand) {
  for (const Valve& valve : {Valve(ThinPlateValve({})), Valve(MpyeValve(MpyeChannel::a)),
                             Valve(MpyeValve(MpyeChannel::b_mirrored))}) {
    for (double u = 3.0; u < 7.0; u += 0.13) {
      for (double p = 110e3; p < 690e3; p += 7e3) {
        const double m = mass_flow_kg_s(valve, p, u, kSupply_Pa, kAmbient_Pa);
        EXPECT_LE(mass_flow_kg_s(valve, p + 7e3, u, kSupply_Pa, kAmbient_Pa), m) << u << " V, " << p << " Pa";
      }
    }
  }
  const Valve valve = ThinPlateValve({});
  for (double u = 3.0; u < 7.0; u += 0.13) {
    EXPECT_GT(mass_flow_kg_s(valve, 3e5, u + 0.13, kSupply_Pa, kAmbient_Pa),
              mass_flow_kg_s(valve, 3e5, u, kSupply_Pa, kAmbient_Pa))
        << u << " V";
  }
}

TEST(TwoPortChamber, SteadyStateIsTheRootOfTheFlow) {
  const Valve valve = ThinPlateValve({});
  double before = 0.0;
  for (double u = 3.0; u < 7.0; u += 0.13) {
    const double p = steady_state_Pa(valve, u, kSupply_Pa, kAmbient_Pa);
    EXPECT_GT(mass_flow_kg_s(valve, p - 1.0, u, kSupply_Pa, kAmbient_Pa), 0.0) << u << " V";
    EXPECT_LT(mass_flow_kg_s(valve, p + 1.0, u, kSupply_Pa, kAmbient_Pa), 0.0) << u << " V";
    EXPECT_GT(p, before) << u << " V";
    before = p;
  }
}

TEST(TwoPortChamber, BothChokedRestsWhereAreasBalance) {
  // a_c P_c = a_r p while p < P_c / theta and p > theta P_r
  ThinPlateValveConfig c;
  c.inlet_leak_m2 = 2e-7, c.exhaust_leak_m2 = 4.5e-7, c.transition_m2 = 0.0;
  const Valve valve = ThinPlateValve(c);
  EXPECT_NEAR(steady_state_Pa(valve, 5.0, kSupply_Pa, kAmbient_Pa), kSupply_Pa * 2.0 / 4.5, 1e-2);
}

TEST(TwoPortChamber, CrackingRatiosLeaveABandAtRest) {
  // at 5 V: inlet shut above a P_c, exhaust shut below P_r / a
  const Valve valve = MpyeValve(MpyeChannel::a);
  const RestBand band = rest_band(valve, 5.0, kSupply_Pa, kAmbient_Pa);
  EXPECT_NEAR(band.low_Pa, 0.750 * kSupply_Pa, 1.0);
  EXPECT_NEAR(band.high_Pa, kAmbient_Pa / 0.187, 1.0);
}

}  // namespace
}  // namespace plenum::host::plant
