#include "host-sim/plant/servo/friction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace plenum::host::plant::servo {
namespace {

const Friction kSeal{30.0, 15.0, 0.02, 80.0};

TEST(Friction, EqualsTheFormulaInBothDirections) {
  const double v = 0.05;
  const double expected = 30.0 + 15.0 * std::exp(-2.5) + 80.0 * v;
  EXPECT_NEAR(sliding_friction_N(kSeal, 1.0, v), expected, 1e-12);
  EXPECT_NEAR(sliding_friction_N(kSeal, -1.0, -v), -expected, 1e-12);
}

TEST(Friction, StartsAtTheBreakawayForceAndEndsCoulombAndViscous) {
  EXPECT_DOUBLE_EQ(sliding_friction_N(kSeal, 1.0, 0.0), kSeal.breakaway_N());
  EXPECT_NEAR(sliding_friction_N(kSeal, 1.0, 2.0), 30.0 + 160.0, 1e-12);
}

TEST(Friction, GaussianExponentIsFlatAtRestWhereThePrintedOneIsSteep) {
  Friction gaussian = kSeal;
  gaussian.stribeck_exponent = 2.0;
  const double v = 1e-4;
  EXPECT_NEAR(sliding_friction_N(kSeal, 1.0, v) - kSeal.breakaway_N() - 80.0 * v, -15.0 * v / 0.02, 1e-3);
  EXPECT_NEAR(sliding_friction_N(gaussian, 1.0, v) - kSeal.breakaway_N() - 80.0 * v, 0.0, 1e-3);
}

TEST(Friction, RefusesNegativeForcesAndNamesThem) {
  try {
    validate(Friction{-1.0, 0.0, 0.01, 0.0});
    FAIL() << "a negative Coulomb friction was accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("coulomb_N"), std::string::npos) << e.what();
  }
  EXPECT_THROW(validate(Friction{1.0, 0.0, 0.0, 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::plant::servo
