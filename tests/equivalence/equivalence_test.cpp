// What the board computes in fixed point against the same in double, for admissible models of every kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "tests/equivalence/core.hpp"
#include "tests/equivalence/drawn.hpp"

namespace equivalence {
namespace {

using plenum::config::ModelKind;

class OfKind : public ::testing::TestWithParam<ModelKind> {};

constexpr int kModels = 6'000;
constexpr int kStates = 6;  // of each model: 108,000 in all three kinds

TEST_P(OfKind, PredictsATickWithinTwoHundredthsOfAPercentOfTheSpan) {
  std::mt19937 random(31);
  std::uniform_real_distribution<float> volts(0.0F, 10.0F), share(0.0F, 1.0F);
  for (int i = 0; i < kModels; ++i) {
    const Drawn drawn = draw(random, GetParam());
    const auto fixed = core_in_fixed(drawn.kind, drawn.parameters),
               exact = core_in_double(drawn.kind, drawn.parameters);
    const double span_kPa = drawn.supply_kPa - drawn.ambient_kPa;
    for (int k = 0; k < kStates; ++k) {
      State from = drawn.state;
      from.pressure_kPa = static_cast<double>(
          static_cast<float>(drawn.ambient_kPa + span_kPa * static_cast<double>(share(random))));
      const double command_V = static_cast<double>(volts(random));
      const Prediction got = fixed->step(from, command_V), want = exact->step(from, command_V);
      ASSERT_NEAR(got.end_kPa, want.end_kPa, 2e-4 * span_kPa) << "model " << i << ", " << command_V << " V";
      ASSERT_NEAR(got.mean_kPa, want.mean_kPa, 2e-4 * span_kPa) << "model " << i << ", " << command_V << " V";
    }
  }
}

// Where a volt moves the pressure by less than kLeastSlope a tick, commands far apart are one to the chamber.
TEST_P(OfKind, CommandsWithinTwoStepsOfTheConverter) {
  constexpr double kStep_V = 10.0 / 65536, kLeastSlope_kPa_V = 1.0;
  std::mt19937 random(32);
  std::uniform_real_distribution<float> volts(0.0F, 10.0F), share(0.0F, 1.0F);
  int compared = 0;
  for (int i = 0; i < kModels; ++i) {
    const Drawn drawn = draw(random, GetParam());
    const auto fixed = core_in_fixed(drawn.kind, drawn.parameters),
               exact = core_in_double(drawn.kind, drawn.parameters);
    const double span_kPa = drawn.supply_kPa - drawn.ambient_kPa;
    for (int k = 0; k < kStates; ++k) {
      State from = drawn.state;
      from.pressure_kPa = static_cast<double>(
          static_cast<float>(drawn.ambient_kPa + span_kPa * static_cast<double>(share(random))));
      const double target_kPa =
          std::clamp(from.pressure_kPa + 0.1 * span_kPa * (2.0 * static_cast<double>(share(random)) - 1.0),
                     drawn.ambient_kPa, drawn.supply_kPa);
      const double near_V = static_cast<double>(volts(random));
      const Inverse got = fixed->inverse(from, target_kPa, near_V),
                    want = exact->inverse(from, target_kPa, near_V);
      const bool told_apart =
          std::min(std::fabs(slope_kPa_V(*exact, from, got.command_V)),
                   std::fabs(slope_kPa_V(*exact, from, want.command_V))) >= kLeastSlope_kPa_V;
      if (!told_apart) continue;
      ++compared;
      ASSERT_NEAR(got.command_V, want.command_V, 2 * kStep_V)
          << "model " << i << ", from " << from.pressure_kPa << " to " << target_kPa << " near " << near_V;
    }
  }
  EXPECT_GT(compared, kModels * kStates / 4) << "states in which the command matters";
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
