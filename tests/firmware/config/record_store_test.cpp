// A set is stored whole or not at all: shown by cutting the power at every write and sync, at every byte of a write,
// with every fate of what was not synced yet, and by damaging every byte.
#include "firmware/config/record_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "firmware/config/crc32.hpp"
#include "tests/firmware/config/power_cut_medium.hpp"

namespace plenum::config {
namespace {

using ports::StoreResult;

/// A body that no prefix, suffix or mixture of others equals: longer than one piece.
Bytes body_of(std::uint8_t set, std::size_t size = 700) {
  Bytes body(size);
  for (std::size_t i = 0; i < size; ++i) body[i] = static_cast<std::uint8_t>(set * 31U + i * 7U + i / 256U);
  return body;
}

struct Found {
  LoadResult result = LoadResult::empty;
  std::optional<Bytes> body;
  std::uint32_t generation = 0;
};

Found load(PowerCutMedium& medium, RecordStore& store) {
  Bytes body(kMaxBodyBytes);
  const RecordStore::Loaded loaded = store.load(body);
  Found found{.result = loaded.result, .body = {}, .generation = store.generation()};
  if (loaded.result == LoadResult::good || loaded.result == LoadResult::fell_back) {
    found.body = Bytes(body.begin(), body.begin() + static_cast<std::ptrdiff_t>(loaded.size));
  }
  EXPECT_EQ(medium.operations, 0) << "reading writes nothing";
  return found;
}

Found after_restart(const Slots& slots) {
  PowerCutMedium medium(slots);
  RecordStore store(medium);
  return load(medium, store);
}

/// Slots after each of the sets was stored, one after the other.
Slots stored(std::initializer_list<std::uint8_t> sets) {
  PowerCutMedium medium;
  RecordStore store(medium);
  load(medium, store);
  for (const std::uint8_t set : sets) EXPECT_EQ(store_all(store, body_of(set)), StoreResult::done);
  return medium.durable;
}

/// The last slot written, and the one before it, of `count` sets.
std::size_t newest_slot(std::size_t count) {
  return (count - 1) % 2;
}

TEST(RecordStore, ThatIsNewHoldsNothingAndIsNoLoss) {
  EXPECT_EQ(after_restart(PowerCutMedium::blank()).result, LoadResult::empty);
  Slots erased{Bytes(kMaxSlotBytes, 0xFF), Bytes(kMaxSlotBytes, 0xFF)};
  EXPECT_EQ(after_restart(erased).result, LoadResult::empty);
}

TEST(RecordStore, FindsTheLastOfManySetsWithItsGeneration) {
  PowerCutMedium medium;
  RecordStore store(medium);
  for (std::uint8_t set = 1; set <= 9; ++set) {
    ASSERT_EQ(store_all(store, body_of(set, 100U * set)), StoreResult::done);
    const Found found = after_restart(medium.durable);
    EXPECT_EQ(found.result, LoadResult::good);
    EXPECT_EQ(found.body, body_of(set, 100U * set));
    EXPECT_EQ(found.generation, set);
    EXPECT_EQ(store.generation(), set);
  }
}

TEST(RecordStore, KeepsASetOfAnySizeUpToTheLargest) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, RecordStore::kPieceBytes, kMaxBodyBytes}) {
    PowerCutMedium medium;
    RecordStore store(medium);
    ASSERT_EQ(store_all(store, body_of(5, size)), StoreResult::done);
    EXPECT_EQ(after_restart(medium.durable).body, body_of(5, size)) << size << " bytes";
  }
}

TEST(RecordStore, WritesNoMoreThanOnePieceAStep) {
  PowerCutMedium medium;
  RecordStore store(medium);
  const Bytes body = body_of(1, 5000);
  store.begin(body);
  int steps = 0;
  for (auto result = StoreResult::busy; result == StoreResult::busy; ++steps) {
    const int before = medium.operations;
    result = store.step();
    EXPECT_EQ(medium.operations, before + 1);
    for (const auto& write : medium.unsynced) EXPECT_LE(write.bytes.size(), RecordStore::kPieceBytes);
  }
  EXPECT_EQ(steps, 10 + 3) << "5000 bytes in pieces of 512, a sync, the header, a sync";
}

TEST(RecordStore, WaitsForAMediumThatIsBusy) {
  PowerCutMedium medium;
  medium.patience = 3;
  RecordStore store(medium);
  EXPECT_EQ(store_all(store, body_of(1)), StoreResult::done);
  EXPECT_EQ(after_restart(medium.durable).body, body_of(1));
  EXPECT_EQ(medium.operations, 2 + 3);
}

TEST(RecordStore, PrefersTheNewerSetAcrossTheWrapAroundOfTheGeneration) {
  const auto slot_with = [](std::uint32_t generation, const Bytes& body) {
    Bytes slot(kMaxSlotBytes);
    const HeaderBytes header = encode_header({.generation = generation,
                                              .length = static_cast<std::uint32_t>(body.size()),
                                              .body_crc = crc32(body)});
    std::copy(header.begin(), header.end(), slot.begin());
    std::copy(body.begin(), body.end(), slot.begin() + kRecordHeaderBytes);
    return slot;
  };
  for (const bool swapped : {false, true}) {
    Slots slots{slot_with(0xFFFF'FFFF, body_of(1)), slot_with(0, body_of(2))};
    if (swapped) std::swap(slots[0], slots[1]);
    EXPECT_EQ(after_restart(slots).body, body_of(2));
    PowerCutMedium medium(slots);
    RecordStore store(medium);
    load(medium, store);
    ASSERT_EQ(store_all(store, body_of(3)), StoreResult::done);
    EXPECT_EQ(after_restart(medium.durable).body, body_of(3));
    EXPECT_EQ(after_restart(medium.durable).generation, 1U);
  }
}

// ---- power cuts ----

struct Begin {
  const char* name;
  Slots slots;
};

std::vector<Begin> beginnings() {
  std::vector<Begin> all{{"empty", PowerCutMedium::blank()},
                         {"one set", stored({1})},
                         {"two sets", stored({1, 2})},
                         {"three sets", stored({1, 2, 3})}};
  const auto damaged = [&](const char* name, std::size_t slot, std::size_t at) {
    Slots slots = stored({1, 2});
    slots[slot][at] ^= 0x10;
    all.push_back({name, slots});
  };
  damaged("newer body damaged", newest_slot(2), kRecordHeaderBytes + 600);
  damaged("newer header damaged", newest_slot(2), 9);
  damaged("older body damaged", 1 - newest_slot(2), kRecordHeaderBytes + 5);
  damaged("older header damaged", 1 - newest_slot(2), 21);
  Slots lost = stored({1, 2});
  lost[0][30] ^= 1;
  lost[1][2] ^= 1;
  all.push_back({"both damaged", lost});
  return all;
}

TEST(RecordStore, HoldsTheOldSetOrTheNewOneWhereverThePowerIsCut) {
  const Bytes fresh = body_of(77, 900), later = body_of(78, 300);
  std::size_t cuts = 0;
  for (const Begin& begin : beginnings()) {
    SCOPED_TRACE(begin.name);
    const std::optional<Bytes> old = after_restart(begin.slots).body;
    int operation = 0;
    for (bool finished = false; !finished; ++operation) {
      PowerCutMedium medium(begin.slots);
      medium.cut_at = operation;
      RecordStore store(medium);
      load(medium, store);
      finished = store_all(store, fresh) == StoreResult::done;
      for_each_survival(medium, [&](const Slots& slots) {
        ++cuts;
        PowerCutMedium again(slots);
        RecordStore restarted(again);
        const Found found = load(again, restarted);
        if (finished) {
          ASSERT_EQ(found.body, fresh) << "was durable";
        } else if (found.body != fresh) {
          ASSERT_EQ(found.body, old) << "operation " << operation;
        }
        // and the store goes on from there
        ASSERT_EQ(store_all(restarted, later), StoreResult::done);
        ASSERT_EQ(after_restart(again.durable).body, later) << "operation " << operation;
      });
    }
    EXPECT_EQ(operation, 2 + 3 + 1) << "two pieces, a sync, the header, a sync, and no cut";
  }
  EXPECT_GT(cuts, 10'000U);
}

// The power fails again while the restarted board stores, as often as it likes.
TEST(RecordStore, HoldsTheOldSetOrTheNewOneThroughTwoCutsOnEnd) {
  const Bytes old = body_of(1), second = body_of(2, 600), third = body_of(3, 650);
  const Slots begin = stored({1});
  for (int first_cut = 0; first_cut < 5; ++first_cut) {
    PowerCutMedium medium(begin);
    medium.cut_at = first_cut;
    RecordStore store(medium);
    load(medium, store);
    store_all(store, second);
    for_each_survival(medium, [&](const Slots& slots) {
      for (int second_cut = 0; second_cut < 5; ++second_cut) {
        PowerCutMedium again(slots);
        again.cut_at = second_cut;
        RecordStore restarted(again);
        const std::optional<Bytes> in_force = load(again, restarted).body;
        store_all(restarted, third);
        for (const bool kept : {false, true}) {
          std::vector<std::size_t> sizes;
          for (const auto& write : again.unsynced) sizes.push_back(kept ? write.bytes.size() : 0);
          const std::optional<Bytes> found = after_restart(again.survive(sizes)).body;
          ASSERT_TRUE(found == in_force || found == third) << "cuts " << first_cut << ", " << second_cut;
        }
      }
    });
  }
}

// ---- damage ----

TEST(RecordStore, GivesAWholeSetOrNamesTheLossWhicheverByteIsDamaged) {
  const Slots whole = stored({1, 2});
  const std::size_t newest = newest_slot(2);
  for (std::size_t slot = 0; slot < 2; ++slot) {
    for (std::size_t at = 0; at < kRecordHeaderBytes + 700; ++at) {
      for (const std::uint8_t flip : Bytes{0x01, 0x80, 0xFF}) {
        Slots slots = whole;
        slots[slot][at] ^= flip;
        const Found found = after_restart(slots);
        if (slot == newest) {
          ASSERT_EQ(found.body, body_of(1)) << "byte " << at;
          ASSERT_EQ(found.result, LoadResult::fell_back) << "byte " << at;
        } else {
          ASSERT_EQ(found.body, body_of(2)) << "byte " << at;
          // a header that cannot be read may have been the newer one's
          ASSERT_EQ(found.result, at < kRecordHeaderBytes ? LoadResult::fell_back : LoadResult::good);
        }
      }
    }
  }
}

TEST(RecordStore, GivesNothingWhenBothSlotsAreDamagedAndGoesOn) {
  for (std::size_t at = 0; at < kRecordHeaderBytes + 700; ++at) {
    Slots slots = stored({1, 2});
    slots[0][at] ^= 1;
    slots[1][kRecordHeaderBytes + 699 - at * 699 / 723] ^= 1;
    EXPECT_EQ(after_restart(slots).result, LoadResult::lost) << "byte " << at;
    PowerCutMedium medium(slots);
    RecordStore store(medium);
    load(medium, store);
    ASSERT_EQ(store_all(store, body_of(3)), StoreResult::done);
    // a damaged header of a higher generation must not pass for a loss for ever
    EXPECT_EQ(after_restart(medium.durable).body, body_of(3));
    EXPECT_NE(after_restart(medium.durable).result, LoadResult::lost);
  }
}

TEST(RecordStore, CountsOnFromTheGenerationOfADamagedSet) {
  Slots slots = stored({1, 2, 3, 4});
  for (Bytes& slot : slots) slot[kRecordHeaderBytes] ^= 1;
  PowerCutMedium medium(slots);
  RecordStore store(medium);
  EXPECT_EQ(load(medium, store).result, LoadResult::lost);
  ASSERT_EQ(store_all(store, body_of(5)), StoreResult::done);
  const Found found = after_restart(medium.durable);
  EXPECT_EQ(found.generation, 5U);
  EXPECT_EQ(found.result, LoadResult::good);
}

// ---- a medium that refuses ----

TEST(RecordStore, KeepsTheSetInForceWhateverTheMediumRefuses) {
  for (int good = 0; good < 5; ++good) {
    PowerCutMedium medium(stored({1, 2}));
    RecordStore store(medium);
    load(medium, store);
    const Bytes third = body_of(3);
    store.begin(third);
    for (int i = 0; i < good; ++i) ASSERT_EQ(store.step(), StoreResult::busy);
    medium.refuses = true;
    EXPECT_EQ(store.step(), StoreResult::failed);
    EXPECT_EQ(store.generation(), 2U);
    medium.refuses = false;
    ASSERT_EQ(store_all(store, body_of(4)), StoreResult::done);
    EXPECT_EQ(after_restart(medium.durable).body, body_of(4));
    EXPECT_EQ(store.generation(), 3U);
  }
}

// Otherwise the set stored now would be followed, after a restart, by the one that could not be read.
TEST(RecordStore, WritesOverASlotThatCannotBeReadRatherThanBesideIt) {
  for (std::uint8_t slot = 0; slot < 2; ++slot) {
    PowerCutMedium medium(stored({1, 2}));
    medium.durable[1 - slot].assign(kMaxSlotBytes, 0);
    medium = PowerCutMedium(medium.durable);
    medium.unreadable[slot] = true;
    RecordStore store(medium);
    EXPECT_EQ(load(medium, store).result, LoadResult::lost);
    ASSERT_EQ(store_all(store, body_of(3)), StoreResult::done);
    EXPECT_EQ(after_restart(medium.durable).body, body_of(3));
  }
}

TEST(RecordStore, WritesNothingWhenNeitherSlotCanBeRead) {
  PowerCutMedium medium(stored({1, 2}));
  medium.unreadable = {true, true};
  RecordStore store(medium);
  EXPECT_EQ(load(medium, store).result, LoadResult::lost);
  EXPECT_EQ(store_all(store, body_of(3)), StoreResult::failed);
  EXPECT_EQ(medium.operations, 0);
  EXPECT_EQ(after_restart(medium.durable).body, body_of(2));
}

}  // namespace
}  // namespace plenum::config
