// What the board takes of a grey-box model, and what it refuses by name.
#include <gtest/gtest.h>

#include <string_view>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"
#include "tests/firmware/config/edited_model.hpp"

namespace plenum::config {
namespace {

using testing::place_of;

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
  return testing::verdict_with(thin_plate(), name, value);
}

TEST(GreyboxImage, ComesBackAsItWasEncoded) {
  testing::expect_comes_back(thin_plate());
}

TEST(GreyboxImage, AKindBeyondTheKnownOnesIsRefused) {
  ModelParameters model = thin_plate();
  model.kind = static_cast<ModelKind>(4);
  EXPECT_EQ(validate(model).error, ImageError::unknown_kind);
}

TEST(GreyboxImage, EveryParameterIsHeldToItsRange) {
  testing::expect_held_to_ranges(thin_plate());
}

TEST(GreyboxImage, TheSupplyIsAboveTheAmbient) {
  testing::expect_supply_above_ambient(thin_plate());
}

TEST(GreyboxImage, BetweenChokedAndShutThereIsRoomForTheFlowToFall) {
  ModelParameters model = thin_plate();
  model.value[place_of(model.kind, "critical_ratio")] = 0.8F;
  model.value[place_of(model.kind, "cracking_ratio")] = 0.85F;
  EXPECT_TRUE(validate(model));
  model.value[place_of(model.kind, "critical_ratio")] = 0.81F - 0.01F + 1e-6F;
  EXPECT_FALSE(validate(model)) << "out of its range";
  model.value[place_of(model.kind, "critical_ratio")] = 0.8F;
  model.value[place_of(model.kind, "cracking_ratio")] = 0.8499F;
  EXPECT_FALSE(validate(model));
}

TEST(GreyboxImage, APortThatShutsAgainOnItsWayIsRefusedWithWhere) {
  const ImageVerdict verdict = with("exhaust_slope", -2.0F);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of(ModelKind::greybox, "exhaust_slope"));
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
