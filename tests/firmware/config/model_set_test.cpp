// The images of several chambers as one value, and their staging: all or none, one a tick.
#include "firmware/config/model_set.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "firmware/config/parameter_slots.hpp"
#include "tests/firmware/config/tassa9_sample.hpp"

namespace plenum::config {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes image_of_chamber(std::size_t chamber) {
  ModelParameters p = tassa9_sample();
  p.value[kC7] = 10.0F + static_cast<float>(chamber);
  return image_of(p);
}

Bytes set_of(std::uint8_t mask) {
  Bytes set{mask};
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    if ((std::uint32_t{mask} >> chamber & 1U) == 0) continue;
    const Bytes image = image_of_chamber(chamber);
    set.insert(set.end(), image.begin(), image.end());
  }
  return set;
}

/// Where the image of the `nth` chamber of a set begins.
std::size_t image_at(std::size_t nth) {
  return 1 + nth * image_of_chamber(0).size();
}

std::uint32_t crc_of(std::uint8_t mask) {
  std::vector<std::uint32_t> crcs;
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    if ((std::uint32_t{mask} >> chamber & 1U) != 0) crcs.push_back(trailing_crc(image_of_chamber(chamber)));
  }
  return commit_crc(crcs);
}

TEST(ModelSet, YieldsTheImagesOfItsMaskInChamberOrder) {
  ModelSet set;
  ASSERT_TRUE(set.take(set_of(0x92)));
  for (const unsigned chamber : {1U, 4U, 7U}) {
    ASSERT_NE(set.left(), 0U);
    const ModelSet::One one = set.next();
    EXPECT_EQ(one.chamber, chamber);
    EXPECT_EQ(Bytes(one.image.begin(), one.image.end()), image_of_chamber(chamber));
  }
  EXPECT_EQ(set.left(), 0U);
}

TEST(ModelSet, IsNotTakenWhenItsImagesDoNotEndWhereItEnds) {
  const Bytes whole = set_of(0x07);
  ModelSet set;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(set.take(std::span(whole).first(size))) << size << " bytes";
    EXPECT_EQ(set.left(), 0U);
  }
  Bytes longer = whole;
  longer.push_back(0);
  EXPECT_FALSE(set.take(longer));
  Bytes nobodys = whole;
  nobodys[0] = 0;
  EXPECT_FALSE(set.take(nobodys));
  EXPECT_FALSE(set.take(Bytes{0}));
  Bytes endless = whole;
  endless[image_at(2) + 10] = 0xFF;  // the parameter count of the third image
  endless[image_at(2) + 11] = 0xFF;
  EXPECT_FALSE(set.take(endless));
  EXPECT_FALSE(set.take(Bytes(kMaxSetBytes + 1, 0xFF)));
  EXPECT_TRUE(set.take(whole));
}

TEST(ModelSet, OfTheLargestImagesFits) {
  Bytes set{0xFF};
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    Bytes image(kMaxImageBytes);
    image[10] = kMaxParameters;
    set.insert(set.end(), image.begin(), image.end());
  }
  ModelSet taken;
  EXPECT_EQ(set.size(), kMaxSetBytes);
  EXPECT_TRUE(taken.take(set));
}

TEST(ParameterSlots, StageOneImageOfASetAtEachTicksEdge) {
  ParameterSlots slots;
  ASSERT_EQ(slots.hand_in(set_of(0xFF)), SetHandIn::taken);
  for (unsigned tick = 0; tick < kChambers; ++tick) {
    EXPECT_TRUE(slots.set_progress().staging);
    EXPECT_EQ(slots.commit(0x01, crc_of(0x01), kCommitKey), CommitResult::not_now);
    EXPECT_EQ(slots.apply_at_tick_edge(), 0U);
    for (std::uint8_t chamber = 0; chamber < kChambers; ++chamber) {
      EXPECT_EQ(slots.state(chamber).phase, chamber <= tick ? SetPhase::staged : SetPhase::empty);
    }
  }
  EXPECT_FALSE(slots.set_progress().staging);
  EXPECT_EQ(slots.set_progress().refused, 0U);
  ASSERT_EQ(slots.commit(0xFF, crc_of(0xFF), kCommitKey), CommitResult::accepted);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0xFFU);
  EXPECT_EQ(slots.active(6).value[kC7], 16.0F);
}

TEST(ParameterSlots, StageNothingOfASetOfWhichOneImageIsRefused) {
  for (std::size_t bad = 0; bad < kChambers; ++bad) {
    ParameterSlots slots;
    Bytes set = set_of(0xFF);
    set[image_at(bad) + 40] ^= 1U;
    ASSERT_EQ(slots.hand_in(set), SetHandIn::taken);
    for (unsigned tick = 0; tick < kChambers; ++tick) slots.apply_at_tick_edge();
    EXPECT_FALSE(slots.set_progress().staging);
    EXPECT_EQ(slots.set_progress().refused, bad + 1);
    EXPECT_EQ(slots.state(static_cast<std::uint8_t>(bad)).refusal.error, ImageError::bad_crc);
    for (std::uint8_t chamber = 0; chamber < kChambers; ++chamber) {
      EXPECT_EQ(slots.state(chamber).phase, chamber == bad ? SetPhase::refused : SetPhase::empty);
      const auto mask = static_cast<std::uint8_t>(1U << chamber);
      EXPECT_EQ(slots.commit(mask, crc_of(mask), kForceKey), CommitResult::nothing_staged);
    }
  }
}

TEST(ParameterSlots, LeaveAChamberThatTheSetDoesNotNameAlone) {
  ParameterSlots slots;
  ASSERT_TRUE(slots.stage(3, image_of_chamber(3)));
  ASSERT_EQ(slots.commit(0x08, crc_of(0x08), kCommitKey), CommitResult::accepted);
  ASSERT_EQ(slots.hand_in(set_of(0x05)), SetHandIn::taken)
      << "a commit that waits is no reason: it comes first";
  EXPECT_EQ(slots.apply_at_tick_edge(), 0x08U);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0U);
  EXPECT_EQ(slots.state(3).phase, SetPhase::active);
  EXPECT_EQ(slots.commit(0x05, crc_of(0x05), kCommitKey), CommitResult::accepted);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0x05U);
  EXPECT_EQ(slots.state(3).generation, 1U);
}

TEST(ParameterSlots, TakeNothingElseWhileASetIsBeingStaged) {
  ParameterSlots slots;
  ASSERT_EQ(slots.hand_in(set_of(0x03)), SetHandIn::taken);
  EXPECT_EQ(slots.hand_in(set_of(0x04)), SetHandIn::not_now);
  EXPECT_EQ(slots.stage(0, image_of_chamber(5)).error, ImageError::staged_by_another);
  slots.apply_at_tick_edge();
  EXPECT_EQ(slots.stage(0, image_of_chamber(5)).error, ImageError::staged_by_another);
  slots.apply_at_tick_edge();
  EXPECT_EQ(slots.commit(0x03, crc_of(0x03), kCommitKey), CommitResult::accepted);
}

TEST(ParameterSlots, TakeOneSetForOneToken) {
  ParameterSlots slots;
  ASSERT_TRUE(slots.upload_session().take(7));
  EXPECT_EQ(slots.hand_in(set_of(0x01)), SetHandIn::taken);
  slots.apply_at_tick_edge();
  EXPECT_EQ(slots.hand_in(set_of(0x01)), SetHandIn::not_now) << "without a token before it";
  ASSERT_TRUE(slots.upload_session().take(7));
  EXPECT_EQ(slots.hand_in(Bytes{1, 2, 3}), SetHandIn::malformed);
  ASSERT_TRUE(slots.upload_session().take(7));
  EXPECT_EQ(slots.hand_in(set_of(0x01)), SetHandIn::taken) << "a malformed one is none that is being staged";
}

}  // namespace
}  // namespace plenum::config
