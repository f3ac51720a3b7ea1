// The 9-parameter model against the paper's equations in double, its derivatives against differences, and its
// inverse against a dense scan of all commands.
#include "firmware/control/tassa9.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "firmware/config/model_image.hpp"
#include "tests/firmware/control/admissible.hpp"
#include "tests/firmware/control/model_properties.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

using testing::motion_of;
using testing::random_chamber;
using testing::RandomChamber;

constexpr auto model_of = [](const RandomChamber& chamber, float low_V = 0.0F, float high_V = 10.0F) {
  Tassa9 model;
  model.configure(scalars(chamber.parameters), low_V, high_V);
  return model;
};

TEST(RandomChambers, AreAdmissible) {
  std::mt19937 random(7);
  for (int i = 0; i < 20'000; ++i) {
    const RandomChamber chamber = random_chamber(random);
    config::ModelParameters parameters;
    parameters.kind = config::ModelKind::tassa9;
    parameters.count = 12;
    std::copy(chamber.parameters.begin(), chamber.parameters.end(), parameters.value.begin());
    const config::ImageVerdict verdict = config::validate(parameters);
    ASSERT_TRUE(verdict) << "set " << i << ": " << config::describe(verdict.error) << " parameter "
                         << int{verdict.parameter} << " = " << verdict.value;
  }
}

TEST(Tassa9, StepIsTheExactSolutionOfThePaper) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> command(0.0F, 10.0F);
  std::uniform_real_distribution<float> part(0.0F, 1.0F);
  for (int i = 0; i < 50'000; ++i) {
    const RandomChamber chamber = random_chamber(random);
    const float u = command(random);
    const float ticks = i % 2 == 0 ? 1.0F : part(random);
    const auto [s, r] = testing::reference(chamber, static_cast<double>(u));
    const double rh = r * 0.01 * static_cast<double>(ticks);
    const double p = static_cast<double>(chamber.pressure_kPa);
    const double end = s + (p - s) * std::exp(-rh);
    const double mean = std::fabs(rh) < 1e-9 ? p : s + (p - s) * -std::expm1(-rh) / rh;
    const Prediction got = model_of(chamber).step(chamber.pressure_kPa, u, motion_of(chamber), ticks);
    // Single precision: the sigmoid's argument keeps about 6e-7 of its value; s and p are of order 1000 kPa.
    const double tolerance = 2e-6 * (std::fabs(s) + std::fabs(p)) + 1e-3;
    ASSERT_NEAR(real(got.end_kPa), end, tolerance) << "set " << i << " u " << u << " rh " << rh;
    ASSERT_NEAR(real(got.mean_kPa), mean, tolerance) << "set " << i << " u " << u << " rh " << rh;
  }
}

TEST(Tassa9, TwoHalfStepsAreOneStep) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> command(0.0F, 10.0F);
  for (int i = 0; i < 5'000; ++i) {
    const RandomChamber chamber = random_chamber(random);
    const Tassa9 model = model_of(chamber);
    const float u = command(random);
    const auto [s, r] = testing::reference(chamber, static_cast<double>(u));
    const Prediction whole = model.step(chamber.pressure_kPa, u, motion_of(chamber), 1.0F);
    const Prediction first = model.step(chamber.pressure_kPa, u, motion_of(chamber), 0.5F);
    const Prediction second = model.step(first.end_kPa, u, motion_of(chamber), 0.5F);
    const double tolerance = 1e-5 * (std::fabs(real(whole.end_kPa)) + std::fabs(s)) + 1e-3;
    ASSERT_NEAR(real(second.end_kPa), real(whole.end_kPa), tolerance) << "set " << i;
    ASSERT_NEAR(real(0.5F * (first.mean_kPa + second.mean_kPa)), real(whole.mean_kPa), tolerance)
        << "set " << i;
  }
}

TEST(Tassa9, DerivativesAreTheLimitsOfDifferences) {
  testing::expect_limits_of_differences(
      model_of,
      [](const RandomChamber& chamber, double command_V) {
        const auto [s, r] = testing::reference(chamber, command_V);
        return s + (static_cast<double>(chamber.pressure_kPa) - s) * std::exp(-r * 0.01);
      },
      [](const RandomChamber& chamber, double command_V) {
        const double r = testing::reference(chamber, command_V).rate_per_s;
        return r >= 0.01 && r * 0.01 <= 20.0;  // outside, the exponent is limited
      });
}

TEST(Tassa9Inverse, ComesAsCloseAsTheBestOfADenseScanForEveryAdmissibleSet) {
  testing::expect_as_close_as_a_dense_scan(model_of, 10'000, 100);
}

TEST(Tassa9Inverse, TakesTheBranchOnWhichPressureRisesWithTheCommand) {
  testing::expect_the_rising_branch(model_of);
}

TEST(Tassa9Inverse, OpensFullyWhereTheFormulaPutsAnOpenExhaustAbovePressure) {
  // c4 v' = 80 kPa: the formula lets an open exhaust settle at 181 kPa, and ranks a shut valve first by a
  // hair.
  const std::array<float, 12> shrinking = {5,  0.5F, 1.5F,  -0.4F, 0.002F, 0.004F,
                                           80, 0.1F, 0.02F, 1.5F,  700,    101.3F};
  Tassa9 model;
  model.configure(scalars(shrinking), 3.0F, 7.0F);
  const ChamberMotion motion{.volume_mL = 500, .volume_rate_mL_s = -200};
  const Inverse got = model.inverse(176, 150, motion, 4.8F);
  EXPECT_EQ(got.command_V, 3.0F);
  EXPECT_TRUE(got.saturated);
}

TEST(Tassa9Inverse, SaysWhenTheTargetIsOutOfReach) {
  Tassa9 model;
  const std::array<float, 12> typical = {5, 1, 2, 0, 0, 0.01F, 50, 0, 0.02F, 0.1F, 620, 101.3F};
  model.configure(scalars(typical), 3.0F, 7.0F);
  testing::expect_limits_out_of_reach(model);
}

}  // namespace
}  // namespace plenum::control
