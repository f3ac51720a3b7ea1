// What the board takes of a grey-box model, and what it refuses by name.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include <string>
#include <string_view>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"

namespace plenum::config {
namespace {

std::size_t place_of(std::string_view name) {
  const auto schema = parameter_schema(ModelKind::greybox);
  for (std::size_t i = 0; i < schema.size(); ++i)
    if (schema[i].name == name) return i;
  ADD_FAILURE() << "no parameter " << name;
  return 0;
}

/// A thin plate of a valve of 60 mL/s a volt.
ModelParameters thin_plate() {
  ModelParameters model;
  model.kind = ModelKind::greybox;
  model.count = kGreyboxParameters;
  model.value = {5.08F, 4.92F, 60.0F, 64.0F, 1.0F, 1.0F, 2.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F,   0.0F,  0.53F,
                 0.5F,  1.0F,  0.0F,  5.0F,  1.4F, 0.0F, 0.0F, 0.0F, 0.8F, 0.0F, 0.0F, 700.0F, 101.3F};
  return model;
}

ImageVerdict with(std::string_view name, float value) {
  ModelParameters model = thin_plate();
  model.value[place_of(name)] = value;
  return validate(model);
}

TEST(GreyboxImage, ComesBackAsItWasEncoded) {
  std::array<std::uint8_t, kMaxImageBytes> bytes{};
  const std::size_t size = encode(thin_plate(), bytes);
  ASSERT_EQ(size, 28U + 4U * 27U + 4U);
  ModelParameters read;
  ASSERT_TRUE(decode(std::span(bytes).first(size), read));
  EXPECT_EQ(read.kind, ModelKind::greybox);
  EXPECT_EQ(read.value, thin_plate().value);
}

TEST(GreyboxImage, AKindBeyondTheKnownOnesIsRefused) {
  ModelParameters model = thin_plate();
  model.kind = static_cast<ModelKind>(4);
  EXPECT_EQ(validate(model).error, ImageError::unknown_kind);
}

TEST(GreyboxImage, EveryParameterIsHeldToItsRange) {
  for (const ParameterSpec& spec : parameter_schema(ModelKind::greybox)) {
    for (const float beyond : {std::nextafter(spec.low, -1e9F), std::nextafter(spec.high, 1e9F)}) {
      const ImageVerdict verdict = with(spec.name, beyond);
      EXPECT_EQ(verdict.error, ImageError::out_of_range) << spec.name;
      EXPECT_EQ(verdict.parameter, place_of(spec.name));
      EXPECT_EQ(verdict.value, beyond);
    }
  }
}

TEST(GreyboxImage, TheSupplyIsAboveTheAmbient) {
  const ImageVerdict verdict = with("supply_kPa", 101.3F);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of("supply_kPa"));
  EXPECT_EQ(verdict.low, 101.3F);
}

TEST(GreyboxImage, BetweenChokedAndShutThereIsRoomForTheFlowToFall) {
  ModelParameters model = thin_plate();
  model.value[place_of("critical_ratio")] = 0.8F;
  model.value[place_of("cracking_ratio")] = 0.85F;
  EXPECT_TRUE(validate(model));
  model.value[place_of("critical_ratio")] = 0.81F - 0.01F + 1e-6F;
  EXPECT_FALSE(validate(model)) << "out of its range";
  model.value[place_of("critical_ratio")] = 0.8F;
  model.value[place_of("cracking_ratio")] = 0.8499F;
  EXPECT_FALSE(validate(model));
}

TEST(GreyboxImage, APortThatShutsAgainOnItsWayIsRefusedWithWhere) {
  const ImageVerdict verdict = with("exhaust_slope", -2.0F);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of("exhaust_slope"));
  EXPECT_EQ(verdict.value, -2.0F);
  // d/do [o - 2 o^2/(o + 2)] = 0 at (o + 2)^2 = 2 o^2 + 8 o, o = 2 sqrt(2) - 2 = 0.828 V
  EXPECT_NEAR(verdict.low, 0.8F, 1e-5F);
  EXPECT_NEAR(verdict.high, 0.9F, 1e-5F);
  EXPECT_TRUE(with("exhaust_slope", -0.9F));
}

TEST(GreyboxImage, APortThatSaturatesFartherOnIsTaken) {
  // d/do [o - 1.5 o^2/(o + 2)] = 0 at (o + 2)^2 = 1.5 (o^2 + 4 o), o = 2 sqrt(3) - 2 = 1.46 V
  EXPECT_TRUE(with("inlet_slope", -1.5F));
}

}  // namespace
}  // namespace plenum::config
