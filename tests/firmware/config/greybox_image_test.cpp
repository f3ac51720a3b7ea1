// What the board takes of a grey-box model, and what it refuses by name.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <numbers>
#include <span>
#include <string_view>
#include <utility>

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
  model.value = {5.08F, 4.92F, 60.0F, 64.0F, 1.0F, 1.0F,   2.0F,   0.0F, 0.0F, 0.0F,
                 0.0F,  0.0F,  0.0F,  0.53F, 0.5F, 1.0F,   0.0F,   5.0F, 1.4F, 0.0F,
                 0.0F,  0.0F,  0.8F,  0.0F,  0.0F, 700.0F, 101.3F, 0.4F, 0.1F, 1.0F};
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

TEST(GreyboxImage, MayLeaveOutWhatItWouldSayOfTheSuppliesLine) {
  ModelParameters model = thin_plate();
  for (model.count = kSupplyResistance; model.count <= kGreyboxParameters; ++model.count) {
    std::array<std::uint8_t, kMaxImageBytes> bytes{};
    const std::size_t size = encode(model, bytes);
    ModelParameters back;
    ASSERT_TRUE(decode(std::span(bytes).first(size), back)) << model.count;
    EXPECT_EQ(back.count, model.count);
    EXPECT_EQ(back.value[kSupplyResistance], model.count > kSupplyResistance ? 0.4F : 0.0F);
    EXPECT_EQ(back.value[kSupplyFollowed], model.count > kSupplyFollowed ? 1.0F : 0.0F);
  }
  model.count = kAmbient;
  EXPECT_EQ(validate(model).error, ImageError::wrong_count);
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
  // o (1 + q o/(o + 2)) rises from 0.9 V to 1 V, where it is bent most, for q above -0.1/(1/3 - 0.81/2.9)
  EXPECT_NEAR(verdict.low, -0.1 / (1.0 / 3.0 - 0.81 / 2.9), 1e-4);
  EXPECT_EQ(verdict.high, 20.0F);
  EXPECT_TRUE(with("exhaust_slope", -0.9F));
}

TEST(GreyboxImage, TheSlopeThatARefusalNamesIsTheLeastThatIsTaken) {
  for (const auto& [curve, bend] : {std::pair{0.0F, 0.0F}, {-3.0F, 0.0F}, {4.0F, -9.0F}, {-20.0F, 40.0F}}) {
    ModelParameters model = thin_plate();
    model.value[kInletCurve] = curve;
    model.value[kInletBend] = bend;
    const float low = testing::verdict_with(model, "inlet_slope", -6.0F).low;
    EXPECT_TRUE(testing::verdict_with(model, "inlet_slope", low + 1e-3F))
        << "curve " << curve << ", bend " << bend;
    EXPECT_EQ(testing::verdict_with(model, "inlet_slope", low - 1e-3F).error, ImageError::not_admissible)
        << "curve " << curve << ", bend " << bend;
  }
}

// z/(pi f) of the spool, half of it a delay and at most four ticks of it no delay, half a tick more for the lag, and the dead time.
TEST(GreyboxImage, DeadTimeAndSpoolTogetherAreNoLongerThanABoardCanLookOver) {
  const auto late = [](float dead_s, float period_s, float damping) {
    ModelParameters model = thin_plate();
    model.value[kDeadTime] = dead_s;
    model.value[kSpoolPeriod] = period_s;
    model.value[kSpoolDamping] = damping;
    return validate(model);
  };
  EXPECT_TRUE(late(0.08F, 0.0F, 2.0F));
  EXPECT_TRUE(late(0.08F, 0.1F, 1.0F)) << "3.2 ticks: 9.6 in all";
  const ImageVerdict verdict = late(0.08F, 0.3F, 1.0F);
  EXPECT_EQ(verdict.error, ImageError::not_admissible) << "9.5 ticks, of which 5.5 are delay: 13.5";
  EXPECT_EQ(verdict.parameter, place_of(ModelKind::greybox, "spool_period_s"));
  EXPECT_EQ(verdict.value, 0.3F);
  EXPECT_EQ(verdict.low, 0.0F);
  EXPECT_NEAR(verdict.high, std::numbers::pi * 0.07, 1e-5) << "of 3.5 ticks that are left half of seven";
  EXPECT_TRUE(late(0.08F, verdict.high - 1e-5F, 1.0F));
  EXPECT_FALSE(late(0.08F, verdict.high + 1e-5F, 1.0F));
  // without dead time four ticks of lag, and 11.5 of delay
  EXPECT_NEAR(late(0.0F, 0.5F, 2.0F).high, std::numbers::pi * 0.155 / 2.0, 1e-5);
}

TEST(GreyboxImage, ADeadVolumeLeavesTheChamberAVolume) {
  ModelParameters model = thin_plate();
  model.value[kDeadVolume] = -93.0F;
  EXPECT_TRUE(validate_volume(model, 93.5F));
  const ImageVerdict verdict = validate_volume(model, 93.0F);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of(ModelKind::greybox, "dead_volume_mL"));
  EXPECT_EQ(verdict.value, -93.0F);
  EXPECT_EQ(verdict.low, -93.0F);
  EXPECT_EQ(verdict.high, 5000.0F);
}

TEST(GreyboxImage, APortThatSaturatesFartherOnIsTaken) {
  // d/do [o - 1.5 o^2/(o + 2)] = 0 at (o + 2)^2 = 1.5 (o^2 + 4 o), o = 2 sqrt(3) - 2 = 1.46 V
  EXPECT_TRUE(with("inlet_slope", -1.5F));
}

}  // namespace
}  // namespace plenum::config
