// What the board takes of a repaired 9-parameter model, and what it refuses by name.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "firmware/config/model_image.hpp"
#include "tests/firmware/config/edited_model.hpp"

namespace plenum::config {
namespace {

using testing::place_of;

ModelParameters sample() {
  ModelParameters model;
  model.kind = ModelKind::tassa9r;
  model.count = 12;
  model.value = {5.02F, 2.5F, 4.0F, 0.02F, 0.02F, 40.0F, 0.1F, 0.08F, 0.1F, 620.0F, 101.325F, 0.025F};
  return model;
}

TEST(Tassa9rImage, HasTheParametersOfThePublishedFormButC4) {
  const std::vector<std::string> expected = {"c1_V",      "c2_per_V",   "c3_per_V3",   "c5_per_mL",
                                             "c6_per_mL", "c7_per_V_s", "c8",          "c9_V",
                                             "c_gamma_V", "supply_kPa", "ambient_kPa", "dead_time_s"};
  std::vector<std::string> found;
  for (const ParameterSpec& spec : parameter_schema(ModelKind::tassa9r)) found.emplace_back(spec.name);
  EXPECT_EQ(found, expected);
  EXPECT_NE(schema_hash(ModelKind::tassa9r), schema_hash(ModelKind::tassa9));
}

TEST(Tassa9rImage, ComesBackAsItWasEncoded) {
  testing::expect_comes_back(sample());
  EXPECT_EQ(dead_time_s(sample()), 0.025F);
  ModelParameters silent = sample();
  silent.value[--silent.count] = 0.0F;
  testing::expect_comes_back(silent);
  EXPECT_EQ(dead_time_s(silent), std::nullopt);
}

TEST(Tassa9rImage, EveryParameterIsHeldToTheRangeThatThePublishedFormHas) {
  const auto published = parameter_schema(ModelKind::tassa9);
  for (const ParameterSpec& spec : parameter_schema(ModelKind::tassa9r)) {
    const ParameterSpec& same = published[place_of(ModelKind::tassa9, spec.name)];
    EXPECT_EQ(spec.low, same.low) << spec.name;
    EXPECT_EQ(spec.high, same.high) << spec.name;
  }
  testing::expect_held_to_ranges(sample());
}

TEST(Tassa9rImage, TheSupplyIsAboveTheAmbient) {
  testing::expect_supply_above_ambient(sample());
}

// c8 = 0.6: sqrt(1 - c8^2) = 0.8, so that c9 must exceed 0.2 c_gamma.
TEST(Tassa9rImage, ALeakTooSmallForItsRateAsymmetryIsBlamed) {
  ModelParameters model = sample();
  model.value[place_of(model.kind, "c8")] = 0.6F;
  model.value[place_of(model.kind, "c_gamma_V")] = 0.5F;
  model.value[place_of(model.kind, "c9_V")] = 0.0999F;
  const ImageVerdict verdict = validate(model);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of(model.kind, "c9_V"));
  EXPECT_NEAR(verdict.low, 0.1F + kRateMargin_V, 1e-7F);
  model.value[place_of(model.kind, "c9_V")] = 0.1002F;
  EXPECT_TRUE(validate(model));
}

// c1 = 4 V: the farthest command is 6 V away, where c2 = 1.08 allows c3 down to -1.08 / 108 = -0.01.
TEST(Tassa9rImage, AKinkThatFoldsTheSteadyStateIsBlamed) {
  ModelParameters model = sample();
  model.value[place_of(model.kind, "c1_V")] = 4.0F;
  model.value[place_of(model.kind, "c2_per_V")] = 1.08F;
  model.value[place_of(model.kind, "c3_per_V3")] = -0.0101F;
  const ImageVerdict verdict = validate(model);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of(model.kind, "c3_per_V3"));
  EXPECT_NEAR(verdict.low, -0.01F, 1e-8F);
}

}  // namespace
}  // namespace plenum::config
