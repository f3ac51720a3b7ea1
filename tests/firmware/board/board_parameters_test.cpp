// 1010h and 1011h of a whole board (CiA 301, 7.5.2.13 and 14): what is kept, when, and what is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <optional>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using canopen::kLoadSignature;
using canopen::kSaveSignature;
using canopen::NmtCommand;
using ::testing::AnyOf;
using ::testing::Eq;
namespace object = canopen::object;

enum Group : std::uint8_t { all = 1, communication = 2, application = 3 };

struct Saving : Bench {
  explicit Saving(const config::Slots& slots = config::PowerCutMedium::blank()) {
    store = config::PowerCutMedium(slots);
    board.start();
    storing = true;
    tick();
    take();
  }
  void save(std::uint8_t group = all) { session.write(object::kStore, group, kSaveSignature); }
  void load(std::uint8_t group = all) { session.write(object::kRestore, group, kLoadSignature); }
  std::uint16_t heartbeat() { return session.read<std::uint16_t>(object::kHeartbeatTime, 0); }
  std::uint8_t preview() { return session.read<std::uint8_t>(object::kPreviewTicks, 0); }
  void set(std::uint16_t heartbeat_ms, std::uint8_t preview_ticks) {
    session.write(object::kHeartbeatTime, 0, heartbeat_ms);
    session.write(object::kPreviewTicks, 0, preview_ticks);
  }
};

using Values = std::map<std::pair<unsigned, unsigned>, std::vector<std::uint8_t>>;

/// Every value that the dictionary keeps, as a client reads it.
Values kept_values(Bench& bench) {
  Values values;
  for (const canopen::Entry& entry : canopen::object_dictionary()) {
    if (entry.kept == canopen::Kept::no) continue;
    for (unsigned instance = 0; instance < entry.instances; ++instance) {
      for (unsigned sub = entry.sub; sub <= entry.last_sub; ++sub) {
        const auto index = static_cast<std::uint16_t>(entry.index + instance * entry.stride);
        values[{index, sub}] = bench.session.sdo_read(index, static_cast<std::uint8_t>(sub));
      }
    }
  }
  return values;
}

/// A board set up otherwise than by default: every kind of value that is kept.
void set_up(Bench& bench) {
  host::client::Session& s = bench.session;
  s.write<std::uint16_t>(object::kHeartbeatTime, 0, 250);
  s.write<std::uint32_t>(object::kEmergencyCobId, 0, 0x8000'0085);
  s.write<std::uint32_t>(object::kEmergencyCobId, 0, 0x91);
  s.write<std::uint32_t>(object::kSyncCobId, 0, 0x81);
  s.configure_setpoints(host::client::SetpointFormat::pascal);  // all RPDOs: mapping and identifiers
  s.write<std::uint16_t>(0x1401, 5, 33);
  s.write<std::uint32_t>(0x1803, 1, 0xC000'0485);  // TPDO4: switched off, its mapping is another one
  s.write<std::uint8_t>(0x1A03, 0, 0);
  s.write<std::uint32_t>(0x1A03, 1, 0x2150'0220);
  s.write<std::uint32_t>(0x1A03, 2, 0x6041'0010);
  s.write<std::uint8_t>(0x1A03, 0, 2);
  s.write<std::uint16_t>(0x1803, 3, 70);
  s.write<std::uint8_t>(0x1803, 2, 254);
  s.write<std::uint32_t>(0x1803, 1, 0x4000'0333);
  s.write<std::uint8_t>(object::kPreviewTicks, 0, 7);
  s.write<float>(object::kCodeScale, 2, 2.5e-8F);
}

std::uint32_t abort_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const host::client::SdoAbort& abort) {
    return abort.code;
  }
  return 0;
}

// ---- the complaints of others' users, by name ----

TEST(Parameters, SettingsThatAreRestoredAreReallyWritten) {
  Saving board;
  const Values defaults = kept_values(board);
  set_up(board);
  const Values wanted = kept_values(board);
  EXPECT_NE(wanted, defaults);
  board.save();
  Saving restarted(board.store.durable);
  EXPECT_EQ(kept_values(restarted), wanted);
  EXPECT_EQ(restarted.image().store.skipped_rows, 0);
  // not only shown: the PDO that was mapped anew is sent under its new identifier
  restarted.session.nmt(NmtCommand::start);
  restarted.run(2);
  bool sent = false;
  for (const auto& frame : restarted.take()) sent = sent || (frame.id == 0x333 && frame.length == 6);
  EXPECT_TRUE(sent);
}

TEST(Parameters, ThirdSaveIsNotLostNorTheHundredth) {
  Saving board;
  for (std::uint16_t i = 1; i <= 100; ++i) {
    board.set(static_cast<std::uint16_t>(1000 + i), static_cast<std::uint8_t>(i % 9));
    board.save();
    Saving restarted(board.store.durable);
    ASSERT_EQ(restarted.heartbeat(), 1000 + i) << "save " << i;
    ASSERT_EQ(restarted.preview(), i % 9);
    if (i % 10 == 0) board.reset(NmtCommand::reset_node);
  }
}

TEST(Parameters, BadCommunicationSettingsAreUndoneByLoadAndCostNoModel) {
  Saving board;
  board.session.upload_model(4, image_of(kValve, 8));
  set_up(board);
  board.save();
  board.load(communication);
  Saving restarted(board.store.durable);
  EXPECT_EQ(restarted.heartbeat(), 1000);
  EXPECT_EQ(restarted.session.read<std::uint32_t>(object::kSyncCobId, 0), 0x80U);
  EXPECT_EQ(restarted.preview(), 7) << "an application parameter";
  EXPECT_EQ(restarted.session.download_model(4), image_of(kValve, 8));
}

// ---- saving ----

TEST(Parameters, SaveIsAnsweredWhenItIsDurableAndNotBefore) {
  Saving board;
  board.storing = false;
  board.set(321, 5);
  board.take();
  board.put(0x600 + Bench::kNode, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'});
  const auto answered = [&] {
    board.tick();
    for (const auto& frame : board.take()) {
      if (frame.id != 0x580 + Bench::kNode) continue;
      EXPECT_EQ(frame.data[0], 0x60);
      return true;
    }
    return false;
  };
  int pieces = 0;
  for (; !answered(); ++pieces) {
    ASSERT_LT(pieces, 100);
    const std::uint16_t now = Saving(board.store.durable).heartbeat();
    ASSERT_TRUE(now == 1000 || now == 321);
    board.board.store_changed();
  }
  EXPECT_GT(pieces, 5);
  EXPECT_EQ(Saving(board.store.durable).heartbeat(), 321);
}

TEST(Parameters, WrongSignatureStoresNothing) {
  Saving board;
  board.set(321, 5);
  for (const std::uint16_t index : {object::kStore, object::kRestore}) {
    const std::uint32_t other = index == object::kStore ? kLoadSignature : kSaveSignature;
    for (const std::uint32_t signature : {0U, 1U, other, 0xFFFF'FFFFU}) {
      EXPECT_EQ(abort_of([&] { board.session.write(index, 1, signature); }), 0x0800'0020U);
    }
    for (std::uint8_t sub = 1; sub <= 3; ++sub)
      EXPECT_EQ(board.session.read<std::uint32_t>(index, sub), 1U) << "on command";
    EXPECT_EQ(board.session.read<std::uint8_t>(index, 0), 3);
    EXPECT_EQ(abort_of([&] { board.session.write(index, 4, kSaveSignature); }), 0x0609'0011U);
  }
  board.run(50);
  EXPECT_EQ(board.store.operations, 0);
}

TEST(Parameters, EachGroupIsSavedByItselfAndLeavesTheOtherAsItWasSaved) {
  Saving board;
  board.set(300, 3);
  board.save(all);
  board.set(400, 4);
  board.save(communication);
  board.set(500, 5);
  {
    Saving restarted(board.store.durable);
    EXPECT_EQ(restarted.heartbeat(), 400);
    EXPECT_EQ(restarted.preview(), 3);
  }
  board.save(application);
  Saving restarted(board.store.durable);
  EXPECT_EQ(restarted.heartbeat(), 400);
  EXPECT_EQ(restarted.preview(), 5);
}

TEST(Parameters, ModelUploadStoresNoValueThatNobodySaved) {
  Saving board;
  board.set(300, 3);
  board.save();
  board.set(400, 4);
  board.session.upload_model(0, image_of(kValve, 1));
  board.run(50);
  Saving restarted(board.store.durable);
  EXPECT_EQ(restarted.heartbeat(), 300);
  EXPECT_EQ(restarted.preview(), 3);
  EXPECT_EQ(restarted.session.download_model(0), image_of(kValve, 1));
}

TEST(Parameters, FailedSaveIsAnsweredWithAHardwareErrorAndKeepsTheOldOnes) {
  Saving board;
  board.set(300, 3);
  board.save();
  board.set(400, 4);
  board.store.refuses = true;
  EXPECT_EQ(abort_of([&] { board.save(); }), 0x0606'0000U);
  EXPECT_EQ(abort_of([&] { board.load(); }), 0x0606'0000U);
  EXPECT_EQ(Saving(board.store.durable).heartbeat(), 300);
  board.reset(NmtCommand::reset_node);
  EXPECT_EQ(board.heartbeat(), 300) << "the board, too, goes on from what is stored";
  board.store.refuses = false;
  board.set(400, 4);
  board.save();
  EXPECT_EQ(Saving(board.store.durable).heartbeat(), 400);
}

TEST(Parameters, SaveWhileAModelIsBeingStoredKeepsBoth) {
  Saving board;
  board.storing = false;
  board.session.upload_model(2, image_of(kValve, 1));
  board.board.store_changed();
  board.board.store_changed();
  board.session.upload_model(3, image_of(kValve, 2));
  board.set(222, 2);
  board.storing = true;
  board.save();
  Saving restarted(board.store.durable);
  EXPECT_EQ(restarted.heartbeat(), 222);
  EXPECT_EQ(restarted.session.download_model(2), image_of(kValve, 1));
  EXPECT_EQ(restarted.session.download_model(3), image_of(kValve, 2));
}

TEST(Parameters, SavingDoesNotDisturbTheRegulation) {
  Bench bench, twin;
  for (Bench* one : {&bench, &twin}) one->go_active(300.0);
  bench.put(0x600 + Bench::kNode, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'});
  for (int i = 0; i < 50; ++i) {
    bench.board.store_changed();
    bench.tick();
    twin.tick();
    ASSERT_EQ(bench.analog_out.held_V, twin.analog_out.held_V) << "tick " << i;
  }
  EXPECT_EQ(bench.image().store.generation, twin.image().store.generation + 1);
}

// ---- restoring ----

TEST(Parameters, LoadTakesEffectWithTheNextReset) {
  struct Case {
    Group group;
    NmtCommand reset;
    std::uint16_t heartbeat;
    std::uint8_t preview;
  };
  for (const Case& c :
       {Case{all, NmtCommand::reset_node, 1000, 0}, Case{all, NmtCommand::reset_communication, 1000, 7},
        Case{communication, NmtCommand::reset_node, 1000, 7},
        Case{application, NmtCommand::reset_node, 250, 0},
        Case{application, NmtCommand::reset_communication, 250, 7}}) {
    Saving board;
    set_up(board);
    board.save();
    board.load(c.group);
    EXPECT_EQ(board.heartbeat(), 250) << "before the reset";
    EXPECT_EQ(board.preview(), 7);
    board.reset(c.reset);
    EXPECT_EQ(board.heartbeat(), c.heartbeat);
    EXPECT_EQ(board.preview(), c.preview);
  }
}

TEST(Parameters, ResetBringsBackWhatWasSavedLast) {
  for (const NmtCommand command : {NmtCommand::reset_communication, NmtCommand::reset_node}) {
    Saving board;
    set_up(board);
    board.save();
    const Values saved = kept_values(board);
    board.set(999, 8);
    board.session.write<std::uint32_t>(0x1803, 1, 0xC000'0333);
    board.reset(command);
    if (command == NmtCommand::reset_communication) {
      EXPECT_EQ(board.preview(), 8) << "an application parameter stays";
      board.session.write<std::uint8_t>(object::kPreviewTicks, 0, 7);
    }
    EXPECT_EQ(kept_values(board), saved);
  }
}

TEST(Parameters, IdentifiersThatHaveChangedHandsComeBack) {
  Saving board;
  host::client::Session& s = board.session;
  for (const std::uint32_t tpdo : {0x1800U, 0x1801U, 0x1802U}) {
    const auto index = static_cast<std::uint16_t>(tpdo);
    s.write<std::uint32_t>(index, 1, s.read<std::uint32_t>(index, 1) | 0x8000'0000);
  }
  s.write<std::uint32_t>(0x1800, 1, 0x4000'0285);        // TPDO2's
  s.write<std::uint32_t>(0x1801, 1, 0x4000'0185);        // TPDO1's
  s.write<std::uint32_t>(object::kSyncCobId, 0, 0x385);  // TPDO3's
  s.write<std::uint32_t>(0x1802, 1, 0x4000'0080);
  board.save();
  const Values saved = kept_values(board);
  Saving restarted(board.store.durable);
  EXPECT_EQ(kept_values(restarted), saved);
  EXPECT_EQ(restarted.image().store.skipped_rows, 0);
  restarted.set(999, 8);
  restarted.reset(NmtCommand::reset_communication);
  restarted.set(1000, 2);
  EXPECT_EQ(restarted.session.read<std::uint32_t>(object::kSyncCobId, 0), 0x385U);
  EXPECT_EQ(restarted.image().store.skipped_rows, 0);
}

TEST(Parameters, RowsOfOtherFirmwareAreSkippedCountedAndNamedAndTheRestApplies) {
  const std::vector<std::uint8_t> two{44, 1}, four{1, 2, 3, 4}, one{6}, reserved{245};
  Saving writer;
  writer.store_models(Bench::images_of(3),
                      {{.index = 0x1017, .sub = 0, .value = two},
                       {.index = 0x1017, .sub = 9, .value = two},
                       {.index = 0x1018, .sub = 4, .value = four},      // known, and not kept
                       {.index = 0x1400, .sub = 2, .value = reserved},  // no transmission type
                       {.index = 0x2160, .sub = 0, .value = four},      // of another size
                       {.index = 0x5FFF, .sub = 1, .value = one},
                       {.index = 0x0000, .sub = 77, .value = one}});
  Saving board(writer.store.durable);
  EXPECT_EQ(board.heartbeat(), 300);
  EXPECT_EQ(board.preview(), 0);
  EXPECT_EQ(board.session.download_model(7), image_of(kValve, 3));
  EXPECT_EQ(board.session.read<std::uint16_t>(object::kStoredSet, 4), 6);
  EXPECT_EQ(board.session.read<std::uint32_t>(object::kStoredSet, 5), 77U) << "0000h:77 is met first";
  EXPECT_EQ(board.image().error_code, 0) << "no fault";
}

TEST(Parameters, PdoWhoseObjectIsGoneIsLeftEmptyAndNeverHalfNew) {
  Saving board;
  set_up(board);
  board.save();
  // other firmware: 2150h:2 of the mapping of TPDO4 is an object that is not there
  std::vector<std::uint8_t> body(config::kMaxBodyBytes);
  config::PowerCutMedium medium(board.store.durable);
  config::RecordStore store(medium);
  body.resize(store.load(body).size);
  const std::vector<std::uint8_t> mapped{0x03, 0x1A, 1, 4, 0x20, 0x02, 0x50, 0x21};
  const auto at = std::search(body.begin(), body.end(), mapped.begin(), mapped.end());
  ASSERT_NE(at, body.end());
  *(at + 7) = 0x5F;
  config::store_all(store, body);
  Saving restarted(medium.durable);
  EXPECT_EQ(restarted.session.read<std::uint8_t>(0x1A03, 0), 0);
  EXPECT_EQ(restarted.session.read<std::uint16_t>(object::kStoredSet, 4), 2)
      << "the object, and the count of two";
  EXPECT_EQ(restarted.session.read<std::uint32_t>(object::kStoredSet, 5), 0x1A0301U);
  EXPECT_EQ(restarted.heartbeat(), 250);
}

// ---- the node id (LSS) ----

TEST(Parameters, StoredNodeIdIsInForceFromTheBootUpMessageOnAndIdentifiersFollowIt) {
  Saving board;
  board.session.write<std::uint16_t>(object::kHeartbeatTime, 0, 200);
  board.session.write<std::uint32_t>(0x1800, 1, 0xC000'0185);
  board.session.write<std::uint32_t>(0x1800, 1, 0x4000'0277);  // an identifier of the user's own
  board.save();

  std::vector<std::uint8_t> body(config::kMaxBodyBytes);
  config::PowerCutMedium medium(board.store.durable);
  config::RecordStore store(medium);
  body.resize(store.load(body).size);
  const std::vector<std::uint8_t> lss{0, 0, 1, 1, 0, 0, 0, 2, 2, 0, 0};  // rows 0:1, no node id, and 0:2
  ASSERT_TRUE(std::equal(lss.begin(), lss.end(), body.begin()));
  body[4] = 9;
  body[9] = 0xF4;  // 500 kbit/s
  body[10] = 0x01;
  config::store_all(store, body);

  Bench moved;
  moved.store = config::PowerCutMedium(medium.durable);
  moved.board.start();
  moved.tick();
  const auto frames = moved.take();
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(frames[0].id, 0x709U);
  for (const auto& frame : frames) EXPECT_NE(frame.id, 0x705U) << "two boot-up messages";
  EXPECT_EQ(moved.board.lss(), (config::LssSettings{.node_id = 9, .bit_rate_kbit = 500}));
  host::client::Session session(moved, 9);
  EXPECT_EQ(session.read<std::uint16_t>(object::kHeartbeatTime, 0), 200);
  EXPECT_EQ(session.read<std::uint32_t>(object::kEmergencyCobId, 0), 0x89U);
  EXPECT_EQ(session.read<std::uint32_t>(0x1400, 1), 0x209U);
  EXPECT_EQ(session.read<std::uint32_t>(0x1801, 1), 0x4000'0289U);
  EXPECT_EQ(session.read<std::uint32_t>(0x1800, 1), 0x4000'0277U);
}

// ---- power cuts ----

TEST(Parameters, SaveLeavesTheOldValuesOrTheNewOnesWhereverThePowerIsCut) {
  Saving before;
  before.session.upload_models(std::vector<host::client::ModelUpload>{{0, image_of(kValve, 1)}});
  before.set(300, 3);
  before.save();
  const config::Slots slots = before.store.durable;
  const auto state_of = [](const config::Slots& found) {
    Saving board(found);
    return std::tuple(board.heartbeat(), board.preview(), board.session.read<std::uint16_t>(0x1803, 3),
                      board.session.download_model(0));
  };
  const auto old = state_of(slots);
  std::optional<decltype(state_of(slots))> fresh;
  int operation = 0;
  for (bool cut = true; cut; ++operation) {
    Saving board(slots);
    set_up(board);
    board.store.cut_at = operation;
    const std::uint32_t abort = abort_of([&] { board.save(); });
    cut = board.store.off;
    if (!cut) {
      EXPECT_EQ(abort, 0U);
      EXPECT_EQ(std::get<0>(state_of(board.store.durable)), 250);
      break;
    }
    EXPECT_EQ(abort, 0x0606'0000U) << "operation " << operation;
    // of what was not synced: nothing, all, the first half, every other write
    std::vector<std::size_t> kept(board.store.unsynced.size());
    for (int way = 0; way < 5; ++way) {
      for (std::size_t i = 0; i < kept.size(); ++i) {
        const std::size_t size = board.store.unsynced[i].bytes.size();
        const bool even = i % 2 == 0;
        kept[i] = way == 0 ? 0 : way == 1 ? size : way == 2 ? size / 2 : (way == 3) == even ? size : 0;
      }
      const auto found = state_of(board.store.survive(kept));
      if (found == old) continue;
      if (!fresh) fresh = found;
      EXPECT_EQ(found, *fresh) << "a mixture, operation " << operation;
      EXPECT_EQ(std::get<0>(found), 250);
      EXPECT_EQ(std::get<1>(found), 7);
      EXPECT_EQ(std::get<2>(found), 70);
    }
  }
  EXPECT_GT(operation, 6);
  EXPECT_TRUE(fresh) << "a header that has come through before its sync is the new set";
}

}  // namespace
}  // namespace plenum
