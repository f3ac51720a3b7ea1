// The 9-parameter model against the paper's equations in double, and its inverse against a dense scan of all commands.
#include "firmware/control/tassa9.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
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

TEST(Tassa9, ComesToRestBetweenItsTwoPressuresHoweverSteepItsCurve) {
  // (c2 + c3 x^2) x is half a million at 8 V from the null
  for (const float c1_V : {2.0F, 8.0F}) {
    const std::array<float, 12> steep = {c1_V, 100, 1000, 0, 0, 0.01F, 1e4F, 0, 0.02F, 0.1F, 700, 100};
    Tassa9 model;
    model.configure(scalars(steep), 0.0F, 10.0F);
    const ChamberMotion still{.volume_mL = 100, .volume_rate_mL_s = 0};
    for (const float away_V : {-2.0F, -1.0F, -0.3F, 0.3F, 1.0F, 2.0F, c1_V < 5 ? 8.0F : -8.0F}) {
      const double rest_kPa = away_V < 0 ? 100.0 : 700.0;
      EXPECT_NEAR(real(model.step(300, c1_V + away_V, still, 1).end_kPa), rest_kPa, 0.1) << away_V << " V";
    }
    const Inverse back = model.inverse(300, 350, still, 5);
    EXPECT_NEAR(real(back.command_V), static_cast<double>(c1_V), 0.02);
    EXPECT_NEAR(real(model.step(300, back.command_V, still, 1).end_kPa), 350.0, 0.01);
  }
}

TEST(Tassa9, AVolumeSlowsItDownAsASmallerRateDoes) {
  constexpr float kFactor = 1'000'001;  // 1 + c6 v
  const std::array<float, 12> of_volume = {5, 1, 2, 0, 0.5F, 1000, 1e6F, 0.1F, 0.02F, 0.1F, 620, 100};
  std::array<float, 12> of_rate = of_volume;
  of_rate[4] /= kFactor;
  of_rate[5] = 0;
  of_rate[6] /= kFactor;
  Tassa9 model, same;
  model.configure(scalars(of_volume), 0.0F, 10.0F);
  same.configure(scalars(of_rate), 0.0F, 10.0F);
  const ChamberMotion motion{.volume_mL = 1000, .volume_rate_mL_s = 1e5F};
  for (const float command_V : {0.0F, 3.0F, 4.9F, 5.1F, 7.0F, 10.0F}) {
    EXPECT_NEAR(real(model.step(300, command_V, motion, 1).end_kPa),
                real(same.step(300, command_V, motion, 1).end_kPa), 2e-3)
        << command_V << " V";
  }
}

TEST(Tassa9Inverse, TellsTheSlopeOfTheEndWhereItAnswers) {
  testing::expect_inverses_to_tell_the_slope(
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

TEST(Tassa9Inverse, ReachesWhatItSaysWhereTheVolumeShiftsTheSteadyStateFarAway) {
  // c4 v' of -1.5 GPa: e^-rh changes by a factor from node to node, and the slope with it
  const std::array<float, 12> far = {3.1376214F,   0.071309641F,   392.348755F, 1000.0F,
                                     1000.0F,      530.899902F,    570531.438F, -0.99999994F,
                                     0.184343949F, 0.00332436501F, 1513.1593F,  167.241959F};
  Tassa9 model;
  model.configure(scalars(far), 0.0F, 10.0F);
  const ChamberMotion motion{.volume_mL = 777.723869F, .volume_rate_mL_s = -1500.0F};
  const Inverse found = model.inverse(1071.09671F, 676.838358F, motion, 1.41760113F);
  EXPECT_FALSE(found.saturated);
  EXPECT_NEAR(real(model.step(1071.09671F, found.command_V, motion, 1.0F).end_kPa), 676.838358, 0.5);
}

TEST(Tassa9Inverse, ReachesWhatItSaysWhereASlopeIsSteeperThanFixedPointCanTell) {
  const std::array<float, 12> steep = {1.46201789F,   0.0173599967F, 0.0996587215F, 1000.0F,
                                       199.16948F,    0.0F,          180726.947F,   -0.863245995F,
                                       0.0326314874F, 0.042375099F,  1837.68238F,   101.3F};
  Tassa9 model;
  model.configure(scalars(steep), 0.0F, 10.0F);
  const ChamberMotion motion{.volume_mL = 133.601515F, .volume_rate_mL_s = -644.426706F};
  const Inverse found = model.inverse(1371.55685F, 371.856785F, motion, 6.0F);
  const double end_kPa = real(model.step(1371.55685F, found.command_V, motion, 1.0F).end_kPa);
  EXPECT_NEAR(real(found.reached_kPa), end_kPa, 1.0) << "at " << real(found.command_V) << " V";
}

TEST(Tassa9Inverse, SaysWhenTheTargetIsOutOfReach) {
  Tassa9 model;
  const std::array<float, 12> typical = {5, 1, 2, 0, 0, 0.01F, 50, 0, 0.02F, 0.1F, 620, 101.3F};
  model.configure(scalars(typical), 3.0F, 7.0F);
  testing::expect_limits_out_of_reach(model);
}

}  // namespace
}  // namespace plenum::control
