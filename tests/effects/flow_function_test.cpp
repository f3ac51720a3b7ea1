// flow_function against the plant, ISO 6358 and closed forms.
#include <gtest/gtest.h>

#include "host-sim/plant/orifice.hpp"
#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

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

}  // namespace
}  // namespace plenum::host::effects
