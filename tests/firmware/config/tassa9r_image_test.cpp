// What the board takes of a repaired 9-parameter model, and what it refuses by name.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/config/model_image.hpp"

namespace plenum::config {
namespace {

const std::vector<std::string> kNames = {"c1_V",      "c2_per_V",   "c3_per_V3",  "c5_per_mL",
                                         "c6_per_mL", "c7_per_V_s", "c8",         "c9_V",
                                         "c_gamma_V", "supply_kPa", "ambient_kPa"};

std::size_t place_of(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (kNames[i] == name) return i;
  ADD_FAILURE() << "no parameter " << name;
  return 0;
}

ModelParameters sample() {
  ModelParameters model;
  model.kind = ModelKind::tassa9r;
  model.count = 11;
  model.value = {5.02F, 2.5F, 4.0F, 0.02F, 0.02F, 40.0F, 0.1F, 0.08F, 0.1F, 620.0F, 101.325F};
  return model;
}

ImageVerdict with(std::string_view name, float value) {
  ModelParameters model = sample();
  model.value[place_of(name)] = value;
  return validate(model);
}

TEST(Tassa9rImage, HasTheParametersOfThePublishedFormButC4) {
  std::vector<std::string> found;
  for (const ParameterSpec& spec : parameter_schema(ModelKind::tassa9r)) found.emplace_back(spec.name);
  EXPECT_EQ(found, kNames);
  EXPECT_NE(schema_hash(ModelKind::tassa9r), schema_hash(ModelKind::tassa9));
}

TEST(Tassa9rImage, ComesBackAsItWasEncoded) {
  std::array<std::uint8_t, kMaxImageBytes> bytes{};
  const std::size_t size = encode(sample(), bytes);
  ASSERT_EQ(size, 28U + 4U * 11U + 4U);
  ModelParameters read;
  ASSERT_TRUE(decode(std::span(bytes).first(size), read));
  EXPECT_EQ(read.kind, ModelKind::tassa9r);
  EXPECT_EQ(read.value, sample().value);
}

TEST(Tassa9rImage, EveryParameterIsHeldToTheRangeThatThePublishedFormHas) {
  for (const ParameterSpec& spec : parameter_schema(ModelKind::tassa9r)) {
    for (const ParameterSpec& published : parameter_schema(ModelKind::tassa9)) {
      if (std::string_view(published.name) != spec.name) continue;
      EXPECT_EQ(spec.low, published.low) << spec.name;
      EXPECT_EQ(spec.high, published.high) << spec.name;
    }
    for (const float beyond : {std::nextafter(spec.low, -1e9F), std::nextafter(spec.high, 1e9F)}) {
      const ImageVerdict verdict = with(spec.name, beyond);
      EXPECT_EQ(verdict.error, ImageError::out_of_range) << spec.name;
      EXPECT_EQ(verdict.parameter, place_of(spec.name));
      EXPECT_EQ(verdict.value, beyond);
    }
  }
}

TEST(Tassa9rImage, TheSupplyIsAboveTheAmbient) {
  const ImageVerdict verdict = with("supply_kPa", 101.325F);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of("supply_kPa"));
  EXPECT_EQ(verdict.low, 101.325F);
}

// c8 = 0.6: sqrt(1 - c8^2) = 0.8, so that c9 must exceed 0.2 c_gamma.
TEST(Tassa9rImage, ALeakTooSmallForItsRateAsymmetryIsBlamed) {
  ModelParameters model = sample();
  model.value[place_of("c8")] = 0.6F;
  model.value[place_of("c_gamma_V")] = 0.5F;
  model.value[place_of("c9_V")] = 0.0999F;
  const ImageVerdict verdict = validate(model);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of("c9_V"));
  EXPECT_NEAR(verdict.low, 0.1F + kRateMargin_V, 1e-7F);
  model.value[place_of("c9_V")] = 0.1002F;
  EXPECT_TRUE(validate(model));
}

// c1 = 4 V: the farthest command is 6 V away, where c2 = 1.08 allows c3 down to -1.08 / 108 = -0.01.
TEST(Tassa9rImage, AKinkThatFoldsTheSteadyStateIsBlamed) {
  ModelParameters model = sample();
  model.value[place_of("c1_V")] = 4.0F;
  model.value[place_of("c2_per_V")] = 1.08F;
  model.value[place_of("c3_per_V3")] = -0.0101F;
  const ImageVerdict verdict = validate(model);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of("c3_per_V3"));
  EXPECT_NEAR(verdict.low, -0.01F, 1e-8F);
}

}  // namespace
}  // namespace plenum::config
