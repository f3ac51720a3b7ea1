#include "firmware/config/parameter_slots.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/firmware/config/tassa9_sample.hpp"

namespace plenum::config {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes image_with_c7(float c7_per_V_s) {
  ModelParameters p = tassa9_sample();
  p.value[kC7] = c7_per_V_s;
  return image_of(p);
}

Bytes spoilt(Bytes image) {
  image.at(40) = static_cast<std::uint8_t>(image.at(40) ^ 1U);
  return image;
}

Bytes active_bytes(const ParameterSlots& slots, std::uint8_t chamber) {
  const auto bytes = slots.active_image(chamber);
  return {bytes.begin(), bytes.end()};
}

std::uint32_t crc_of(std::initializer_list<Bytes> images) {
  std::vector<std::uint32_t> crcs;
  for (const Bytes& image : images) crcs.push_back(trailing_crc(image));
  return commit_crc(crcs);
}

void bring_into_force(ParameterSlots& slots, std::uint8_t chamber, const Bytes& image) {
  ASSERT_TRUE(slots.stage(chamber, image));
  ASSERT_EQ(slots.commit(static_cast<std::uint8_t>(1U << chamber), crc_of({image}), kCommitKey),
            CommitResult::accepted);
  ASSERT_EQ(slots.apply_at_tick_edge(), 1U << chamber);
}

TEST(ParameterSlots, StartEmpty) {
  ParameterSlots slots;
  for (std::uint8_t c = 0; c < kChambers; ++c) {
    EXPECT_TRUE(slots.active_image(c).empty());
    EXPECT_EQ(slots.active(c).kind, ModelKind::none);
    EXPECT_EQ(slots.state(c).phase, SetPhase::empty);
  }
  EXPECT_EQ(slots.apply_at_tick_edge(), 0U);
  EXPECT_EQ(slots.generation(), 0U);
}

TEST(ParameterSlots, ChangeNothingBeforeTheTicksEdge) {
  ParameterSlots slots;
  const Bytes image = image_with_c7(40.0F);
  ASSERT_TRUE(slots.stage(3, image));
  EXPECT_EQ(slots.state(3).phase, SetPhase::staged);
  ASSERT_EQ(slots.commit(1U << 3, crc_of({image}), kCommitKey), CommitResult::accepted);
  EXPECT_EQ(slots.state(3).phase, SetPhase::committed);
  EXPECT_TRUE(slots.active_image(3).empty());
  EXPECT_EQ(slots.active(3).kind, ModelKind::none);

  EXPECT_EQ(slots.apply_at_tick_edge(), 1U << 3);
  EXPECT_EQ(active_bytes(slots, 3), image);
  EXPECT_EQ(slots.active(3).value[kC7], 40.0F);
  EXPECT_EQ(slots.state(3).phase, SetPhase::active);
  EXPECT_EQ(slots.state(3).active_crc, trailing_crc(image));
  EXPECT_EQ(slots.state(3).generation, 1U);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0U) << "a commit is applied once";
}

TEST(ParameterSlots, SwapAllChambersOfACommitTogether) {
  ParameterSlots slots;
  const Bytes a = image_with_c7(10.0F), b = image_with_c7(20.0F), c = image_with_c7(30.0F);
  ASSERT_TRUE(slots.stage(0, a));
  ASSERT_TRUE(slots.stage(7, b));
  ASSERT_TRUE(slots.stage(4, c));
  ASSERT_EQ(slots.commit(0x81, crc_of({a, b}), kCommitKey), CommitResult::accepted);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0x81U);
  EXPECT_EQ(active_bytes(slots, 0), a);
  EXPECT_EQ(active_bytes(slots, 7), b);
  EXPECT_TRUE(slots.active_image(4).empty()) << "not named by the commit";
  EXPECT_EQ(slots.state(4).phase, SetPhase::staged);
}

TEST(ParameterSlots, RefuseWholeACommitThatNamesAnEmptySlot) {
  ParameterSlots slots;
  const Bytes image = image_with_c7(10.0F);
  ASSERT_TRUE(slots.stage(0, image));
  EXPECT_EQ(slots.commit(0x03, crc_of({image}), kCommitKey), CommitResult::nothing_staged);
  EXPECT_EQ(slots.commit(0x00, crc_of({}), kCommitKey), CommitResult::nothing_staged);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0U);
  EXPECT_TRUE(slots.active_image(0).empty());
}

TEST(ParameterSlots, RefuseACommitWithAWrongKeyOrCrc) {
  ParameterSlots slots;
  const Bytes a = image_with_c7(10.0F), b = image_with_c7(20.0F);
  ASSERT_TRUE(slots.stage(0, a));
  ASSERT_TRUE(slots.stage(1, b));
  EXPECT_EQ(slots.commit(0x03, crc_of({a, b}), kCommitKey + 1), CommitResult::wrong_key);
  EXPECT_EQ(slots.commit(0x03, crc_of({b, a}), kCommitKey), CommitResult::wrong_crc) << "chambers swapped";
  EXPECT_EQ(slots.apply_at_tick_edge(), 0U);
  EXPECT_EQ(slots.commit(0x03, crc_of({a, b}), kCommitKey), CommitResult::accepted) << "still staged";
}

TEST(ParameterSlots, KeepTheActiveSetWhenAnImageIsRefused) {
  ParameterSlots slots;
  const Bytes good = image_with_c7(10.0F);
  bring_into_force(slots, 2, good);

  ModelParameters too_far = tassa9_sample();
  too_far.value[kC1] = 8.5F;
  const ImageVerdict verdict = slots.stage(2, image_of(too_far));
  EXPECT_EQ(verdict.error, ImageError::out_of_range);
  EXPECT_EQ(slots.state(2).phase, SetPhase::refused);
  EXPECT_EQ(slots.state(2).refusal.parameter, kC1);
  EXPECT_EQ(slots.state(2).refusal.value, 8.5F);
  EXPECT_EQ(slots.commit(0x04, crc_of({image_of(too_far)}), kCommitKey), CommitResult::nothing_staged);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0U);
  EXPECT_EQ(active_bytes(slots, 2), good);
  EXPECT_EQ(slots.active(2).value[kC7], 10.0F);
  EXPECT_EQ(slots.state(2).generation, 1U);
}

TEST(ParameterSlots, DropTheStagedSetWhenItsSuccessorIsRefused) {
  ParameterSlots slots;
  const Bytes first = image_with_c7(10.0F);
  ASSERT_TRUE(slots.stage(0, first));
  EXPECT_FALSE(slots.stage(0, spoilt(first)));
  EXPECT_EQ(slots.commit(0x01, crc_of({first}), kCommitKey), CommitResult::nothing_staged);
}

TEST(ParameterSlots, ForgetWhatIsStagedButForWhatACommitHasBeenAcceptedFor) {
  ParameterSlots slots;
  const Bytes first = image_with_c7(10.0F), second = image_with_c7(20.0F);
  ASSERT_TRUE(slots.upload_session().take(7));
  ASSERT_TRUE(slots.stage(0, first));
  ASSERT_EQ(slots.commit(0x01, crc_of({first}), kCommitKey), CommitResult::accepted);
  ASSERT_TRUE(slots.upload_session().take(7));
  ASSERT_TRUE(slots.stage(1, second));
  ASSERT_TRUE(slots.upload_session().take(7));
  ASSERT_EQ(slots.hand_in(2, second), ImageError::none);
  slots.forget_staged();
  EXPECT_EQ(slots.upload_session().owner(), 0U);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0x01U);
  EXPECT_EQ(active_bytes(slots, 0), first);
  for (std::uint8_t chamber = 1; chamber <= 2; ++chamber) {
    EXPECT_EQ(slots.state(chamber).phase, SetPhase::empty) << "chamber " << +chamber;
    EXPECT_EQ(slots.commit(static_cast<std::uint8_t>(1U << chamber), crc_of({second}), kForceKey),
              CommitResult::nothing_staged);
  }
}

TEST(ParameterSlots, NeverStageAPartOfAnImage) {
  ParameterSlots slots;
  const Bytes image = image_with_c7(10.0F);
  for (std::size_t size = 0; size < image.size(); ++size) {
    EXPECT_FALSE(slots.stage(0, std::span(image).first(size))) << size << " bytes";
    EXPECT_NE(slots.state(0).phase, SetPhase::staged);
  }
}

TEST(ParameterSlots, AcceptNoImageForAChamberWhoseCommitWaits) {
  ParameterSlots slots;
  const Bytes committed = image_with_c7(10.0F), late = image_with_c7(20.0F);
  ASSERT_TRUE(slots.stage(0, committed));
  ASSERT_EQ(slots.commit(0x01, crc_of({committed}), kCommitKey), CommitResult::accepted);
  EXPECT_EQ(slots.stage(0, late).error, ImageError::commit_pending);
  EXPECT_EQ(slots.commit(0x01, crc_of({committed}), kCommitKey), CommitResult::not_now);
  EXPECT_TRUE(slots.stage(1, late)) << "another chamber is free";
  EXPECT_EQ(slots.apply_at_tick_edge(), 0x01U);
  EXPECT_EQ(active_bytes(slots, 0), committed);
}

TEST(ParameterSlots, ReplaceTheActiveSetAgainAndAgain) {
  ParameterSlots slots;
  for (std::uint32_t round = 1; round <= 5; ++round) {
    const Bytes image = image_with_c7(static_cast<float>(round));
    bring_into_force(slots, 6, image);
    EXPECT_EQ(active_bytes(slots, 6), image);
    EXPECT_EQ(slots.generation(), round);
    EXPECT_EQ(slots.commit(0x40, crc_of({image}), kCommitKey), CommitResult::nothing_staged);
  }
}

TEST(ParameterSlots, RefuseAChamberThatTheBoardDoesNotHave) {
  ParameterSlots slots;
  EXPECT_EQ(slots.stage(8, image_with_c7(10.0F)).error, ImageError::no_such_chamber);
  EXPECT_TRUE(slots.active_image(255).empty());
  EXPECT_EQ(slots.state(8).phase, SetPhase::empty);
}

}  // namespace
}  // namespace plenum::config
