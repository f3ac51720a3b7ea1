// What the board computes in fixed point against the same in double, for admissible models of every kind.
#include <gtest/gtest.h>

#include <string>

#include "tests/equivalence/closed_loop.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/equivalence/states.hpp"

namespace equivalence {
namespace {

using plenum::config::ModelKind;

class OfKind : public ::testing::TestWithParam<ModelKind> {};

constexpr int kModels = 6'000;
constexpr int kStates =
    6;  // of each model: 108,000 in all three kinds, and as many of any that an image may carry

TEST_P(OfKind, PredictsATickWithinTwoHundredthsOfAPercentOfTheSpan) {
  for_each_state(GetParam(), 31, kModels, kStates, [](const Asked& asked) {
    const Prediction got = asked.fixed.step(asked.from, asked.command_V);
    const Prediction want = asked.exact.step(asked.from, asked.command_V);
    ASSERT_NEAR(got.end_kPa, want.end_kPa, 2e-4 * asked.span_kPa)
        << asked.from.pressure_kPa << " kPa, " << asked.command_V << " V";
    ASSERT_NEAR(got.mean_kPa, want.mean_kPa, 2e-4 * asked.span_kPa)
        << asked.from.pressure_kPa << " kPa, " << asked.command_V << " V";
  });
}

TEST_P(OfKind, PredictsATickOfAnyAdmissibleModelWithinTwoHundredthsOfAPercentOfItsReach) {
  for_each_admissible_state(GetParam(), 33, kModels, kStates, [](const Asked& asked) {
    const Prediction got = asked.fixed.step(asked.from, asked.command_V);
    const Prediction want = asked.exact.step(asked.from, asked.command_V);
    const double most_kPa = 2e-4 * reach_kPa(asked, want);
    ASSERT_NEAR(got.end_kPa, want.end_kPa, most_kPa)
        << asked.from.pressure_kPa << " kPa, " << asked.command_V << " V";
    ASSERT_NEAR(got.mean_kPa, want.mean_kPa, most_kPa)
        << asked.from.pressure_kPa << " kPa, " << asked.command_V << " V";
  });
}

TEST_P(OfKind, CommandsWithinTwoStepsOfTheConverter) {
  int compared = 0;
  for_each_state(GetParam(), 32, kModels, kStates, [&](const Asked& asked) {
    const Inverse got = asked.fixed.inverse(asked.from, asked.target_kPa, asked.command_V);
    const Inverse want = asked.exact.inverse(asked.from, asked.target_kPa, asked.command_V);
    if (!commands_matter(asked, got.command_V, want.command_V)) return;
    ++compared;
    ASSERT_NEAR(got.command_V, want.command_V, kMostSteps * kConverterStep_V)
        << "from " << asked.from.pressure_kPa << " to " << asked.target_kPa << " near " << asked.command_V;
  });
  EXPECT_GT(compared, kModels * kStates / 4) << "states in which the command matters";
}

/// One state in 10,000 took more steps than there were, and was answered 85 kPa off.
TEST(OfGreybox, AnInverseReachesItsTargetOrIsSaturated) {
  constexpr double kMissed_kPa = 0.02;
  constexpr int kMany = 5'000, kOfEach = 10;
  int unsaturated = 0;
  const auto reaches = [&](const Asked& asked) {
    const Inverse got = asked.fixed.inverse(asked.from, asked.target_kPa, asked.command_V);
    const Inverse want = asked.exact.inverse(asked.from, asked.target_kPa, asked.command_V);
    for (const double command_V : {got.command_V, want.command_V}) {
      ASSERT_GE(command_V, 0.0);
      ASSERT_LE(command_V, 10.0);
    }
    if (!got.saturated) {
      ASSERT_NEAR(got.reached_kPa, asked.target_kPa, kMissed_kPa) << "in fixed point";
    }
    if (want.saturated) return;
    ++unsaturated;
    ASSERT_NEAR(asked.exact.step(asked.from, want.command_V).end_kPa, asked.target_kPa, kMissed_kPa)
        << "from " << asked.from.pressure_kPa << " near " << asked.command_V;
  };
  for_each_state(ModelKind::greybox, 77, kMany, kOfEach, reaches);
  for_each_admissible_state(ModelKind::greybox, 78, kMany, kOfEach, reaches);
  EXPECT_GT(unsaturated, kMany * kOfEach / 4);
}

TEST(OfGreybox, NoCommandComesNearerThanOneThatIsCalledSaturated) {
  constexpr double kNearer_kPa = 0.02;
  int saturated = 0;
  for_each_state(ModelKind::greybox, 79, kModels, kStates, [&](const Asked& asked) {
    for (const Core* core : {&asked.fixed, &asked.exact}) {
      const Inverse answer = core->inverse(asked.from, asked.target_kPa, asked.command_V);
      if (!answer.saturated) continue;
      ++saturated;
      const auto missed_kPa = [&](double command_V) {
        return std::fabs(asked.exact.step(asked.from, command_V).end_kPa - asked.target_kPa);
      };
      for (double command_V = 0.0; command_V <= 10.0; command_V += 0.25) {
        ASSERT_GE(missed_kPa(command_V), missed_kPa(answer.command_V) - kNearer_kPa)
            << asked.from.pressure_kPa << " to " << asked.target_kPa << " kPa: " << answer.command_V << " V, "
            << command_V << " V";
      }
    }
  });
  EXPECT_GT(saturated, kModels);
}

TEST_P(OfKind, TracksInClosedLoopWithinAPercentOfDouble) {
  const Loops loops = compare_loops(GetParam(), 8);
  EXPECT_LT(loops.worst_rms_kPa, 5) << "it follows its reference, or the ratio would say nothing";
  EXPECT_LT(loops.worst_ratio, 1.01);
  EXPECT_LE(loops.parted, loops.ticks / 10'000) << "ticks in which the commands part";
}

INSTANTIATE_TEST_SUITE_P(Fixed, OfKind,
                         ::testing::Values(ModelKind::tassa9, ModelKind::tassa9r, ModelKind::greybox),
                         [](const auto& of) {
                           return of.param == ModelKind::tassa9    ? std::string("Tassa9")
                                  : of.param == ModelKind::tassa9r ? std::string("Tassa9r")
                                                                   : std::string("Greybox");
                         });

}  // namespace
}  // namespace equivalence
