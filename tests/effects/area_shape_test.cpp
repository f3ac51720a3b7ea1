// area_shape: the areas, measured as choked flow over a large chamber.
#include <gtest/gtest.h>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

/// Of the pressure, 6e-11 Pa, in the tick's gain of 1e-5 Pa from which a small area is read.
constexpr double kRounding = 1e-5;

/// Area of the port that is open at `command_V`, from the flow it passes while choked [m2].
double area_m2(EffectSet on, const Figures& figures, double command_V) {
  const Surroundings around;
  const double beta = plant::thin_plate_constants(around.gas, around.discharge_coefficient).beta_s_m;
  const double flow = flow_kg_s(on, figures, command_V, 3e5, around);
  return flow > 0.0 ? flow / (beta * around.supply_Pa) : -flow / (beta * 3e5);
}

TEST(AreaShape, IsTheStatedPolynomialOfTheOpeningOnEachPort) {
  const Figures shaped = with(sharp_valve(kGain_m2_V), kIdAreaShape, {1.5, -0.8, -2.0, 3.0});
  for (const double opening_V : {0.05, 0.5, 2.0, 4.5}) {
    const double g = opening_V / (opening_V + 2.0);
    EXPECT_NEAR(area_m2(only(kIdAreaShape), shaped, 5.0 + opening_V) / (kGain_m2_V * opening_V),
                1.0 + 1.5 * g - 0.8 * g * g, kRounding)
        << "inlet open by " << opening_V << " V";
    EXPECT_NEAR(area_m2(only(kIdAreaShape), shaped, 5.0 - opening_V) / (kGain_m2_V * opening_V),
                1.0 - 2.0 * g + 3.0 * g * g, kRounding)
        << "exhaust open by " << opening_V << " V";
  }
}

TEST(AreaShape, NearTheNullAnAreaIsTheLinearOneAndFarFromItTheSumOfItsFigures) {
  const Figures shaped = with(sharp_valve(kGain_m2_V), kIdAreaShape, {1.5, -0.8, 0.0, 0.0});
  EXPECT_NEAR(area_m2(only(kIdAreaShape), shaped, 5.001) / (kGain_m2_V * 0.001), 1.0, 1e-3);
  const Figures fine = with(sharp_valve(1e-11), kIdAreaShape, {1.5, -0.8, 0.0, 0.0});
  EXPECT_NEAR(area_m2(only(kIdAreaShape), fine, 5.0 + 1e5) / (1e-11 * 1e5), 1.0 + 1.5 - 0.8, 1e-4);
}

TEST(AreaShape, AreaNeverFallsBelowATwentiethOfTheLinearOne) {
  const Figures shut = with(sharp_valve(kGain_m2_V), kIdAreaShape, {-6.0, -20.0, 0.0, 0.0});
  EXPECT_NEAR(area_m2(only(kIdAreaShape), shut, 9.0) / (kGain_m2_V * 4.0), 0.05, 1e-6);
}

TEST(AreaShape, LeavesTheLeakAndTheTransitionAsTheyAre) {
  // o m(o) in the place of o in (3)
  const double q = 2.0;
  const Figures shaped = with(nominal(), kIdAreaShape, {q, 0.0, 0.0, 0.0});
  for (const double command_V : {5.09, 5.12, 5.3, 7.0}) {
    const double o = command_V - 5.08;
    const double equal_V = 5.08 + o * (1.0 + q * o / (o + 2.0));
    // the exhaust port is left at its leak by both, but for a share of its transition
    EXPECT_NEAR(flow_kg_s(only(kIdAreaShape), shaped, command_V, 101325.0),
                flow_kg_s(0, nominal(), equal_V, 101325.0), 1e-9)
        << "kg/s at " << command_V << " V";
  }
}

}  // namespace
}  // namespace plenum::host::effects
