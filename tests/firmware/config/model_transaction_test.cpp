// Stage, compare, commit: what two masters and a comparison that takes its time may do to the sets in force.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <optional>
#include <vector>

#include "firmware/config/parameter_slots.hpp"
#include "tests/firmware/config/tassa9_sample.hpp"

namespace plenum::config {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes image_with_c7(float c7_per_V_s) {
  ModelParameters p = tassa9_sample();
  p.value[kC7] = c7_per_V_s;
  return image_of(p);
}

Bytes bytes_of(std::span<const std::uint8_t> image) {
  return {image.begin(), image.end()};
}

std::uint32_t crc_of(const std::vector<Bytes>& images) {
  std::vector<std::uint32_t> crcs;
  for (const Bytes& image : images) crcs.push_back(trailing_crc(image));
  return commit_crc(crcs);
}

/// Begins every comparison it is asked for, or none.
class FakeTrial final : public ModelTrial {
 public:
  bool begin(std::uint8_t) noexcept override {
    ++begun;
    return compares;
  }
  int begun = 0;
  bool compares = true;
};

/// Counts the checks that it is asked for.
class FakeProof final : public ModelProof {
 public:
  void begin(std::uint8_t) noexcept override { ++begun; }
  int begun = 0;
};

constexpr ImageVerdict kFails{.error = ImageError::inverse_fails};
constexpr ModelPoint kThere{430.0F, 120.0F, 5.4F, 450.0F, 437.9F};

constexpr TrialResult kPassed{Trial::passed, 1.0F, 1.5F};
constexpr TrialResult kWorse{Trial::worse, 9.0F, 1.5F};

/// Slots with an image in force in chamber 0.
struct Desk {
  FakeTrial trial;
  ParameterSlots slots{&trial};
  Bytes first = image_with_c7(10.0F), second = image_with_c7(20.0F);

  Desk() {
    slots.stage(0, first);
    commit(first);
    slots.apply_at_tick_edge();
  }
  CommitResult commit(const Bytes& image, std::uint32_t key = kCommitKey) {
    return slots.commit(0x01, crc_of({image}), key);
  }
};

TEST(ModelProof, HoldsBackComparisonAndCommitEvenByForce) {
  FakeTrial trial;
  FakeProof proof;
  ParameterSlots slots(&trial, &proof);
  const Bytes image = image_with_c7(10.0F);
  ASSERT_TRUE(slots.stage(0, image));
  EXPECT_EQ(proof.begun, 1);
  EXPECT_EQ(slots.state(0).phase, SetPhase::checking);
  EXPECT_FALSE(slots.checking(0)) << "no comparison yet";
  EXPECT_EQ(slots.commit(0x01, crc_of({image}), kCommitKey), CommitResult::checking);
  EXPECT_EQ(slots.commit(0x01, crc_of({image}), kForceKey), CommitResult::checking);
  slots.prove(0, {}, {});
  EXPECT_EQ(slots.state(0).phase, SetPhase::staged);
  ASSERT_EQ(slots.commit(0x01, crc_of({image}), kCommitKey), CommitResult::accepted);
  slots.apply_at_tick_edge();
  slots.stage(0, image);
  EXPECT_EQ(trial.begun, 0);
  slots.prove(0, {}, {});
  EXPECT_EQ(trial.begun, 1);
  EXPECT_TRUE(slots.checking(0));
}

TEST(ModelProof, RefusesAndTellsWhere) {
  FakeProof proof;
  ParameterSlots slots(nullptr, &proof);
  const Bytes image = image_with_c7(10.0F);
  slots.stage(3, image);
  slots.prove(3, kFails, kThere);
  const SetState state = slots.state(3);
  EXPECT_EQ(state.phase, SetPhase::refused);
  EXPECT_EQ(state.refusal.error, ImageError::inverse_fails);
  EXPECT_EQ(slots.failing_point(3).pressure_kPa, 430.0F);
  EXPECT_EQ(slots.failing_point(3).came_kPa, 437.9F);
  EXPECT_EQ(slots.commit(0x08, crc_of({image}), kForceKey), CommitResult::nothing_staged);
  slots.prove(3, {}, {});
  EXPECT_EQ(slots.state(3).phase, SetPhase::refused) << "it is no longer wanted";
}

TEST(ModelProof, OfOneImageIsThatOfItsWholeSet) {
  for (const bool fails : {false, true}) {
    FakeProof proof;
    ParameterSlots slots(nullptr, &proof);
    const Bytes image = image_with_c7(10.0F);
    Bytes set{0x05};
    for (int i = 0; i < 2; ++i) set.insert(set.end(), image.begin(), image.end());
    ASSERT_EQ(slots.hand_in(set), SetHandIn::taken);
    slots.apply_at_tick_edge();
    slots.prove(0, {}, {});
    slots.apply_at_tick_edge();
    EXPECT_TRUE(slots.set_progress().staging) << "one image is not proved yet";
    EXPECT_EQ(slots.stage(7, image).error, ImageError::staged_by_another);
    slots.prove(2, fails ? kFails : ImageVerdict{}, kThere);
    EXPECT_FALSE(slots.set_progress().staging);
    EXPECT_EQ(slots.set_progress().refused, fails ? 3 : 0);
    EXPECT_EQ(slots.state(0).phase, fails ? SetPhase::empty : SetPhase::staged);
    EXPECT_EQ(slots.state(2).phase, fails ? SetPhase::refused : SetPhase::staged);
  }
}

TEST(ModelProof, OfASingleImageLeavesAnEarlierSetStaged) {
  FakeProof proof;
  ParameterSlots slots(nullptr, &proof);
  const Bytes image = image_with_c7(10.0F);
  Bytes set{0x01};
  set.insert(set.end(), image.begin(), image.end());
  slots.hand_in(set);
  slots.apply_at_tick_edge();
  slots.prove(0, {}, {});
  slots.stage(1, image);
  slots.prove(1, kFails, kThere);
  EXPECT_EQ(slots.state(0).phase, SetPhase::staged);
  EXPECT_EQ(slots.set_progress().refused, 0);
}

TEST(Transaction, HasNothingToCompareWithBeforeThereIsAModel) {
  Desk desk;
  EXPECT_EQ(desk.trial.begun, 0);
  EXPECT_EQ(bytes_of(desk.slots.active_image(0)), desk.first);
}

TEST(Transaction, WaitsForTheComparison) {
  Desk desk;
  ASSERT_TRUE(desk.slots.stage(0, desk.second));
  EXPECT_EQ(desk.slots.state(0).phase, SetPhase::checking);
  EXPECT_EQ(desk.slots.state(0).trial.outcome, Trial::running);
  EXPECT_EQ(desk.commit(desk.second), CommitResult::checking);
  desk.slots.apply_at_tick_edge();
  EXPECT_EQ(bytes_of(desk.slots.active_image(0)), desk.first);
  desk.slots.judge(0, kPassed);
  EXPECT_EQ(desk.slots.state(0).phase, SetPhase::staged);
  EXPECT_EQ(desk.commit(desk.second), CommitResult::accepted);
  desk.slots.apply_at_tick_edge();
  EXPECT_EQ(bytes_of(desk.slots.active_image(0)), desk.second);
  EXPECT_EQ(desk.slots.state(0).trial.active_rms_kPa, 1.5F) << "told still";
}

TEST(Transaction, SaysThatNothingWasComparedAndCommits) {
  Desk desk;
  desk.trial.compares = false;
  ASSERT_TRUE(desk.slots.stage(0, desk.second));
  EXPECT_EQ(desk.slots.state(0).phase, SetPhase::staged);
  EXPECT_EQ(desk.slots.state(0).trial.outcome, Trial::not_compared);
  EXPECT_EQ(desk.commit(desk.second), CommitResult::accepted);
}

TEST(Transaction, TakesAWorseModelByForceOnly) {
  Desk desk;
  ASSERT_TRUE(desk.slots.stage(0, desk.second));
  desk.slots.judge(0, kWorse);
  EXPECT_EQ(desk.slots.state(0).phase, SetPhase::doubted);
  EXPECT_EQ(desk.slots.state(0).refusal.error, ImageError::predicts_worse);
  EXPECT_EQ(desk.slots.state(0).trial.staged_rms_kPa, 9.0F);
  EXPECT_EQ(desk.commit(desk.second), CommitResult::doubted);
  desk.slots.apply_at_tick_edge();
  EXPECT_EQ(bytes_of(desk.slots.active_image(0)), desk.first);
  EXPECT_EQ(desk.commit(desk.second, kForceKey), CommitResult::accepted);
  desk.slots.apply_at_tick_edge();
  EXPECT_EQ(bytes_of(desk.slots.active_image(0)), desk.second);
  EXPECT_EQ(desk.slots.state(0).phase, SetPhase::active);
  EXPECT_TRUE(desk.slots.state(0).refusal);
}

TEST(Transaction, ForceNeedsNoComparison) {
  Desk desk;
  ASSERT_TRUE(desk.slots.stage(0, desk.second));
  EXPECT_EQ(desk.commit(desk.second, kForceKey), CommitResult::accepted);
  desk.slots.judge(0, kWorse);  // comes too late
  EXPECT_EQ(desk.slots.state(0).phase, SetPhase::committed);
  desk.slots.apply_at_tick_edge();
  EXPECT_EQ(desk.slots.state(0).phase, SetPhase::active);
}

TEST(Transaction, ForceDoesNotReplaceTheCrc) {
  Desk desk;
  ASSERT_TRUE(desk.slots.stage(0, desk.second));
  EXPECT_EQ(desk.commit(desk.first, kForceKey), CommitResult::wrong_crc);
}

TEST(Transaction, ANewImageIsComparedAnew) {
  Desk desk;
  ASSERT_TRUE(desk.slots.stage(0, desk.second));
  desk.slots.judge(0, kWorse);
  ASSERT_TRUE(desk.slots.stage(0, image_with_c7(30.0F)));
  EXPECT_EQ(desk.slots.state(0).phase, SetPhase::checking);
  EXPECT_TRUE(desk.slots.state(0).refusal);
  EXPECT_EQ(desk.trial.begun, 2);
}

TEST(Transaction, OneDoubtedChamberKeepsTheWholeCommitBack) {
  Desk desk;
  ASSERT_TRUE(desk.slots.stage(0, desk.second));
  ASSERT_TRUE(desk.slots.stage(5, desk.first)) << "no model there: nothing is compared";
  desk.slots.judge(0, kWorse);
  EXPECT_EQ(desk.slots.commit(0x21, crc_of({desk.second, desk.first}), kCommitKey), CommitResult::doubted);
  EXPECT_EQ(desk.slots.apply_at_tick_edge(), 0U);
  EXPECT_TRUE(desk.slots.active_image(5).empty());
  EXPECT_EQ(desk.slots.commit(0x20, crc_of({desk.first}), kCommitKey), CommitResult::accepted);
}

TEST(Transaction, DoubtsAModelOfAnotherValveOrSensor) {
  // the sample is of valve 4711 and sensor 815
  for (const auto& [serials, field, expected] : {std::tuple{Serials{4712, 815}, kValveSerialField, 4712U},
                                                 std::tuple{Serials{4711, 816}, kSensorSerialField, 816U}}) {
    ParameterSlots slots;
    slots.expect(2, serials);
    const Bytes image = image_with_c7(10.0F);
    ASSERT_TRUE(slots.stage(2, image));
    const SetState state = slots.state(2);
    EXPECT_EQ(state.phase, SetPhase::doubted);
    EXPECT_EQ(state.refusal.error, ImageError::wrong_serial);
    EXPECT_EQ(state.refusal.parameter, field);
    EXPECT_EQ(state.expected_serial, expected);
    EXPECT_EQ(slots.commit(0x04, crc_of({image}), kCommitKey), CommitResult::doubted);
    EXPECT_EQ(slots.commit(0x04, crc_of({image}), kForceKey), CommitResult::accepted);
  }
}

TEST(Transaction, DoubtsNoSerialThatOneSideDoesNotState) {
  ModelParameters unstated = tassa9_sample();
  unstated.valve_serial = 0;
  unstated.sensor_serial = 0;
  ParameterSlots slots;
  slots.expect(0, {.valve = 1, .sensor = 2});
  ASSERT_TRUE(slots.stage(0, image_of(unstated)));
  EXPECT_EQ(slots.state(0).phase, SetPhase::staged);
  ASSERT_TRUE(slots.stage(1, image_with_c7(10.0F))) << "a board that states none";
  EXPECT_EQ(slots.state(1).phase, SetPhase::staged);
  slots.expect(2, {.valve = 4711, .sensor = 815});
  ASSERT_TRUE(slots.stage(2, image_with_c7(10.0F)));
  EXPECT_EQ(slots.state(2).phase, SetPhase::staged);
}

TEST(Transaction, JudgesWhatIsHandedInAtTheTicksEdge) {
  ParameterSlots slots;
  const Bytes good = image_with_c7(10.0F), better = image_with_c7(20.0F);
  Bytes spoilt = good;
  spoilt[40] = static_cast<std::uint8_t>(spoilt[40] ^ 1U);
  ASSERT_EQ(slots.hand_in(3, good), ImageError::none);
  EXPECT_TRUE(slots.judgement().pending);
  EXPECT_EQ(slots.state(3).staged_crc, 0U) << "not before the edge";
  EXPECT_EQ(slots.commit(0x08, crc_of({good}), kCommitKey), CommitResult::not_now);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0U);
  EXPECT_FALSE(slots.judgement().pending);
  EXPECT_TRUE(slots.judgement().verdict);
  EXPECT_EQ(slots.state(3).phase, SetPhase::staged);

  ASSERT_EQ(slots.hand_in(3, spoilt), ImageError::none);
  EXPECT_EQ(slots.commit(0x08, crc_of({good}), kCommitKey), CommitResult::not_now) << "what it names may go";
  EXPECT_EQ(slots.hand_in(4, better), ImageError::staged_by_another) << "one at a time";
  Bytes set{0x01};
  set.insert(set.end(), better.begin(), better.end());
  EXPECT_EQ(slots.hand_in(set), SetHandIn::not_now);
  slots.apply_at_tick_edge();
  EXPECT_EQ(slots.judgement().verdict.error, ImageError::bad_crc);
  EXPECT_EQ(slots.state(3).phase, SetPhase::refused);
  EXPECT_EQ(slots.state(3).refusal.error, ImageError::bad_crc);
  EXPECT_EQ(slots.commit(0x08, crc_of({good}), kCommitKey), CommitResult::nothing_staged);

  EXPECT_EQ(slots.hand_in(3, Bytes(kMaxImageBytes + 1)), ImageError::wrong_size);
  ASSERT_EQ(slots.hand_in(set), SetHandIn::taken);
  EXPECT_EQ(slots.hand_in(4, better), ImageError::staged_by_another);
  slots.apply_at_tick_edge();
  ASSERT_EQ(slots.commit(0x01, crc_of({better}), kCommitKey), CommitResult::accepted);
  EXPECT_EQ(slots.hand_in(0, good), ImageError::commit_pending);
  EXPECT_EQ(slots.hand_in(1, good), ImageError::none) << "the commit names another chamber";
  EXPECT_EQ(slots.apply_at_tick_edge(), 0x01U);
  EXPECT_EQ(bytes_of(slots.active_image(0)), better);
  EXPECT_EQ(slots.state(1).phase, SetPhase::staged);
}

TEST(Transaction, KeepsWhatOneMasterStagedFromAnother) {
  ParameterSlots slots;
  const Bytes mine = image_with_c7(10.0F), other = image_with_c7(20.0F);
  ASSERT_TRUE(slots.upload_session().take(7));
  ASSERT_TRUE(slots.stage(0, mine));
  EXPECT_FALSE(slots.upload_session().take(8));
  EXPECT_EQ(slots.stage(0, other).error, ImageError::staged_by_another);
  EXPECT_EQ(slots.stage(1, other).error, ImageError::staged_by_another);
  EXPECT_EQ(slots.state(0).phase, SetPhase::staged) << "the first master's image stands";
  EXPECT_EQ(slots.state(1).phase, SetPhase::empty);
  EXPECT_EQ(slots.state(1).refusal.error, ImageError::staged_by_another);
  EXPECT_EQ(slots.commit(0x01, crc_of({mine}), kCommitKey), CommitResult::accepted);
  EXPECT_EQ(slots.apply_at_tick_edge(), 0x01U);
  EXPECT_EQ(slots.state(0).phase, SetPhase::active) << "whatever another master tried meanwhile";
}

TEST(Transaction, AnImageThatCameDuringACommitDoesNotHideItsOutcome) {
  ParameterSlots slots;
  const Bytes mine = image_with_c7(10.0F);
  ASSERT_TRUE(slots.stage(0, mine));
  ASSERT_EQ(slots.commit(0x01, crc_of({mine}), kCommitKey), CommitResult::accepted);
  EXPECT_EQ(slots.stage(0, image_with_c7(20.0F)).error, ImageError::commit_pending);
  slots.apply_at_tick_edge();
  EXPECT_EQ(slots.state(0).phase, SetPhase::active);
}

/// What the slots should be, in a few lines: no phases, no layout.
struct Expected {
  struct Staged {
    Bytes image;
    bool running = false;
    bool doubted = false;
  };
  struct HandedIn {
    std::uint8_t chamber;
    Bytes image;
    bool spoilt;
  };
  std::array<std::optional<Staged>, kChambers> staged;
  std::optional<HandedIn> handed_in;
  std::array<Bytes, kChambers> active;
  std::uint8_t pending = 0;
  std::uint32_t generation = 0;
  std::array<std::uint32_t, kChambers> taken_over_at{};
};

/// Two masters, of tokens 1 and 2, and one that knows none (0) do what they like, in any order.
class Storm {
 public:
  void act() {
    switch (*rc::gen::inRange(0, 8)) {
      case 0:
      case 1:
        return stage(false);
      case 2:
        return stage(true);
      case 3:
        return judge();
      case 4:
      case 5:
        return commit();
      case 6:
        return take_or_release();
      default:
        return tick();
    }
  }
  void check() const {
    for (std::uint8_t c = 0; c < kChambers; ++c) {
      RC_ASSERT(bytes_of(slots_.active_image(c)) == expected_.active[c]);
      RC_ASSERT(slots_.state(c).generation == expected_.taken_over_at[c]);
      RC_ASSERT((slots_.state(c).staged_crc != 0) == expected_.staged[c].has_value());
    }
    RC_ASSERT(slots_.generation() == expected_.generation);
  }

 private:
  static std::uint8_t any_chamber() { return *rc::gen::inRange<std::uint8_t>(0, 3); }

  void stage(bool spoilt) {
    const std::uint8_t c = any_chamber();
    Bytes image = image_with_c7(static_cast<float>(++serial_));
    if (spoilt) image[40] = static_cast<std::uint8_t>(image[40] ^ 1U);
    const bool at_once = *rc::gen::arbitrary<bool>();
    const bool admitted =
        (slots_.upload_session().owner() == 0 || ticket_) && !expected_.handed_in.has_value();
    ticket_ = false;
    trial_.compares = *rc::gen::arbitrary<bool>();
    const ImageError error = at_once ? slots_.stage(c, image).error : slots_.hand_in(c, image);
    if (!admitted) {
      RC_ASSERT(error == ImageError::staged_by_another);
    } else if ((expected_.pending >> c & 1) != 0) {
      RC_ASSERT(error == ImageError::commit_pending);
    } else if (at_once) {
      RC_ASSERT(error == (spoilt ? ImageError::bad_crc : ImageError::none));
      expect_judged({c, image, spoilt});
    } else {
      RC_ASSERT(error == ImageError::none);
      expected_.handed_in = {c, image, spoilt};
    }
    RC_ASSERT(slots_.judgement().pending == expected_.handed_in.has_value());
  }
  void expect_judged(const Expected::HandedIn& one) {
    if (one.spoilt) {
      expected_.staged[one.chamber].reset();
    } else {
      const bool runs = trial_.compares && !expected_.active[one.chamber].empty();
      expected_.staged[one.chamber] = {one.image, runs, false};
    }
  }
  void judge() {
    const std::uint8_t c = any_chamber();
    const bool worse = *rc::gen::arbitrary<bool>();
    slots_.judge(c, worse ? kWorse : kPassed);
    auto& staged = expected_.staged[c];
    if (!staged || !staged->running || (expected_.pending >> c & 1) != 0) return;
    staged->running = false;
    staged->doubted = worse;
  }
  void commit() {
    const auto mask = *rc::gen::inRange<std::uint8_t>(0, 8);
    const bool right_crc = *rc::gen::arbitrary<bool>();
    const auto key = *rc::gen::element(kCommitKey, kForceKey, kCommitKey + 1);
    std::vector<Bytes> images;
    bool all_staged = mask != 0, held_back = false;
    for (std::size_t c = 0; c < kChambers; ++c) {
      if ((mask >> c & 1) == 0) continue;
      all_staged = all_staged && expected_.staged[c].has_value();
      if (!expected_.staged[c]) continue;
      images.push_back(expected_.staged[c]->image);
      held_back = held_back || expected_.staged[c]->running || expected_.staged[c]->doubted;
    }
    const bool expected = key != kCommitKey + 1 && all_staged && right_crc && expected_.pending == 0 &&
                          !expected_.handed_in && (!held_back || key == kForceKey);
    const CommitResult result = slots_.commit(mask, crc_of(images) + (right_crc ? 0U : 1U), key);
    RC_ASSERT((result == CommitResult::accepted) == expected);
    if (expected) expected_.pending = mask;
  }
  void take_or_release() {
    const auto token = *rc::gen::inRange<std::uint32_t>(1, 3);
    const std::uint32_t owner = slots_.upload_session().owner();
    if (*rc::gen::arbitrary<bool>()) {
      const bool taken = slots_.upload_session().take(token);
      RC_ASSERT(taken == (owner == 0 || owner == token));
      ticket_ = ticket_ || taken;
    } else {
      const bool released = slots_.upload_session().release(token);
      RC_ASSERT(released == (owner == token));
      if (released) ticket_ = false;
    }
  }
  void tick() {
    RC_ASSERT(slots_.apply_at_tick_edge() == expected_.pending);
    if (expected_.pending != 0) ++expected_.generation;
    for (std::size_t c = 0; c < kChambers; ++c) {
      if ((expected_.pending >> c & 1) == 0) continue;
      expected_.active[c] = expected_.staged[c]->image;
      expected_.taken_over_at[c] = expected_.generation;
      expected_.staged[c].reset();
    }
    expected_.pending = 0;
    if (!expected_.handed_in) return;
    expect_judged(*expected_.handed_in);
    RC_ASSERT(static_cast<bool>(slots_.judgement().verdict) == !expected_.handed_in->spoilt);
    expected_.handed_in.reset();
  }

  FakeTrial trial_;
  ParameterSlots slots_{&trial_};
  Expected expected_;
  bool ticket_ = false;
  int serial_ = 0;
};

TEST(Transaction, BringsIntoForceWholeCommitsAndNothingElseWhateverMastersDo) {
  EXPECT_TRUE(rc::check([] {
    Storm storm;
    for (int i = 0; i < 200; ++i) {
      storm.act();
      storm.check();
    }
  }));
}

}  // namespace
}  // namespace plenum::config
