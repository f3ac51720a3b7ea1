// null_drift: its exponential and its spline, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

/// The drift at whole seconds, 0 to 80, of these coefficients of its spline.
std::vector<double> wander_V(const std::array<double, kNullKnots>& coefficients_V,
                             double knot_s = kLeastKnot_s) {
  std::array<double, 3 + kNullKnots> x{};
  x.back() = knot_s;
  std::copy(coefficients_V.begin(), coefficients_V.end(), x.begin() + 2);
  NullDrift<double> drift;
  drift.prepare(x.data(), kTick_s);
  std::vector<double> at_second_V;
  for (int tick = 0; tick <= 8000; ++tick) {
    if (tick % 100 == 0) at_second_V.push_back(5.0 - drift.at(5.0));
    drift.end_tick();
  }
  return at_second_V;
}

TEST(NullDrift, EachCoefficientOfItsSplineIsACubicBasisFunctionThreeSecondsAKnot) {
  for (std::size_t k = 1; k < kNullKnots; ++k) {
    std::array<double, kNullKnots> coefficients_V{};
    coefficients_V[k - 1] = 0.3;
    const std::vector<double> drift_V = wander_V(coefficients_V);
    for (std::size_t second = 0; second <= 60; ++second) {
      // (2 - |x|)^3/6 - 4 (1 - |x|)^3/6 for |x| < 2, each power where its base is positive
      const double x = std::abs(static_cast<double>(second) / 3.0 - static_cast<double>(k));
      const double expected =
          0.3 * (std::pow(std::max(2.0 - x, 0.0), 3) - 4.0 * std::pow(std::max(1.0 - x, 0.0), 3)) / 6.0;
      EXPECT_NEAR(drift_V[second], expected, 1e-9) << "V, coefficient " << k << " at " << second << " s";
    }
  }
}

TEST(NullDrift, ItsSplineIsStraightWhereItsCoefficientsAreAndStandsAfterTheLast) {
  std::array<double, kNullKnots> coefficients_V{};
  for (std::size_t k = 0; k < kNullKnots; ++k) coefficients_V[k] = 0.01 * static_cast<double>(k + 1);
  const std::vector<double> drift_V = wander_V(coefficients_V);
  EXPECT_NEAR(drift_V.front(), 0.01 / 6.0, 1e-12) << "V";
  for (std::size_t second = 3; second <= 54; ++second) {
    EXPECT_NEAR(drift_V[second], 0.01 * static_cast<double>(second) / 3.0, 1e-9) << "V at " << second << " s";
  }
  EXPECT_NEAR(drift_V[60], 0.01 * (19.0 + 5.0 * 20.0) / 6.0, 1e-12) << "V";
  for (std::size_t second = 63; second <= 80; ++second) {
    EXPECT_NEAR(drift_V[second], coefficients_V.back(), 1e-12) << "V at " << second << " s";
  }
}

TEST(NullDrift, ItsSplineIsTheSameOnceItsKnotsAreFurtherApartAndLater) {
  std::array<double, kNullKnots> coefficients_V{0.1, -0.2, 0.15, 0.3};
  const std::vector<double> near_V = wander_V(coefficients_V);
  const std::vector<double> far_V = wander_V(coefficients_V, 4.0 * kLeastKnot_s);
  for (std::size_t second = 0; second <= 20; ++second) {
    EXPECT_NEAR(far_V[4 * second], near_V[second], 1e-9) << "V at " << second << " s of the closer knots";
  }
}

TEST(NullDrift, FollowsItsExponentialAndReachesItsFigureAtAMinute) {
  for (const double tau_s : {2.0, 25.0, 1e6, kInfinity}) {
    std::array<double, 3 + kNullKnots> x{-0.7, 1.0 / tau_s};
    x.back() = kLeastKnot_s;
    NullDrift<double> drift;
    drift.prepare(x.data(), kTick_s);
    for (int k = 0; k <= 6000; ++k) {
      const double t = k * kTick_s;
      const double share = std::isinf(tau_s) ? t / 60.0 : std::expm1(-t / tau_s) / std::expm1(-60.0 / tau_s);
      ASSERT_NEAR(drift.at(5.0), 5.0 + 0.7 * share, 1e-10) << "V at " << t << " s, tau " << tau_s << " s";
      drift.end_tick();
    }
  }
}

TEST(NullDrift, ShiftsBothPortsByTheSameCommand) {
  // after a minute of ramp the flows are those of a command lower by the drift
  const Figures drifting = with(nominal(), kIdNullDrift, {0.2, kInfinity});
  for (const double command_V : {6.0, 4.0}) {
    EXPECT_NEAR(flow_kg_s(only(kIdNullDrift), drifting, command_V, 3e5, {}, 6001) /
                    flow_kg_s(0, nominal(), command_V - 0.2, 3e5, {}, 6001),
                1.0, 1e-5)
        << "at command " << command_V << " V";
  }
}

}  // namespace
}  // namespace plenum::host::effects
