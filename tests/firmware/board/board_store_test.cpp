// What a board keeps across power cycles, and what it says when it cannot.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using canopen::StorePhase;
using config::LoadResult;
using ::testing::AnyOf;
using ::testing::Each;
using ::testing::Eq;
using ::testing::IsEmpty;
namespace object = canopen::object;

/// The models that a board has in force after a start with these slots.
Bench::Images models_after_restart(const config::Slots& slots) {
  Bench bench;
  bench.store = config::PowerCutMedium(slots);
  bench.board.start();
  Bench::Images images;
  for (std::uint8_t c = 0; c < kChambers; ++c) {
    const auto image = bench.board.controller().active_image(c);
    images[c].assign(image.begin(), image.end());
  }
  return images;
}

std::vector<host::client::ModelUpload> uploads_of(const Bench::Images& images) {
  std::vector<host::client::ModelUpload> uploads;
  for (std::uint8_t c = 0; c < kChambers; ++c) {
    if (!images[c].empty()) uploads.push_back({c, images[c]});
  }
  return uploads;
}

TEST(BoardStore, ModelsFromTheStoreAreNotWrittenBackToIt) {
  Bench bench;
  bench.store_models();
  bench.board.start();
  bench.run(3);
  bench.finish_storing();
  EXPECT_EQ(bench.store.operations, 0);
}

TEST(BoardStore, KeepsTheModelsThatChangedBesideThoseThatDidNot) {
  Bench bench;
  bench.store_models();
  bench.board.start();
  bench.session.upload_models(
      uploads_of({{{}, image_of(kValve, 1), {}, {}, {}, {}, image_of(kValve, 6), {}}}));
  bench.finish_storing();
  Bench::Images expected = Bench::images_of(100);
  expected[1] = image_of(kValve, 1);
  expected[6] = image_of(kValve, 6);
  EXPECT_EQ(models_after_restart(bench.store.durable), expected);
  const int operations = bench.store.operations;
  bench.run(5);
  bench.finish_storing();
  EXPECT_EQ(bench.store.operations, operations) << "stored again without a change";
}

TEST(BoardStore, KeepsAThirdCommitAsItKeptTheFirst) {
  Bench bench;
  bench.board.start();
  for (std::uint32_t serial = 1; serial <= 3; ++serial) {
    bench.session.upload_models(uploads_of(Bench::images_of(serial)));
    bench.finish_storing();
    EXPECT_EQ(models_after_restart(bench.store.durable), Bench::images_of(serial));
  }
}

TEST(BoardStore, StoresTheNewestModelsWhenACommitComesWhileItStores) {
  Bench bench;
  bench.board.start();
  bench.session.upload_models(uploads_of(Bench::images_of(1)));
  bench.board.store_changed();
  bench.board.store_changed();
  bench.session.upload_models(uploads_of(Bench::images_of(2)));
  bench.finish_storing();
  EXPECT_EQ(models_after_restart(bench.store.durable), Bench::images_of(2));
  EXPECT_EQ(bench.image().store.generation, 2U) << "the first set was finished as it was begun";
}

TEST(BoardStore, TellsTheBusWhatIsStoredAndWhatIsNot) {
  Bench bench;
  bench.board.start();
  const auto phase = [&] { return bench.session.read<std::uint8_t>(object::kStoredSet, 1); };
  const auto generation = [&] { return bench.session.read<std::uint32_t>(object::kStoredSet, 3); };
  bench.tick();
  EXPECT_EQ(phase(), 0);
  EXPECT_EQ(bench.session.read<std::uint8_t>(object::kStoredSet, 2), 0) << "nothing was stored";
  EXPECT_EQ(generation(), 0U);
  bench.session.upload_model(0, image_of(kValve, 1));
  EXPECT_EQ(phase(), 1) << "in force, and not stored yet";
  bench.finish_storing();
  EXPECT_EQ(phase(), 0);
  EXPECT_EQ(generation(), 1U);
}

// ---- power cuts ----

TEST(BoardStore, HasTheOldModelsOrTheNewOnesOfAllChambersWhereverThePowerIsCut) {
  const Bench::Images none, old = Bench::images_of(1), fresh = Bench::images_of(2);
  struct Begin {
    const char* name;
    config::Slots slots;
    Bench::Images images;
  };
  const auto slots_of = [&](int sets) {
    Bench bench;
    for (int i = 0; i < sets; ++i) bench.store_models(i + 1 < sets ? Bench::images_of(9) : old);
    return bench.store.durable;
  };
  config::Slots half_damaged = slots_of(2);
  half_damaged[0][config::kRecordHeaderBytes + 3] ^= 1;
  for (const Begin& begin :
       {Begin{"empty", config::PowerCutMedium::blank(), none}, Begin{"one set", slots_of(1), old},
        Begin{"two sets", slots_of(2), old}, Begin{"one of two slots damaged", half_damaged, old}}) {
    SCOPED_TRACE(begin.name);
    ASSERT_EQ(models_after_restart(begin.slots), begin.images);
    int operation = 0;
    for (bool cut = true; cut; ++operation) {
      Bench bench;
      bench.store = config::PowerCutMedium(begin.slots);
      bench.board.start();
      bench.session.upload_models(uploads_of(fresh));
      bench.store.cut_at = operation;
      bench.finish_storing();
      cut = bench.store.off;
      config::for_each_survival(bench.store, [&](const config::Slots& slots) {
        const Bench::Images found = models_after_restart(slots);
        if (cut) {
          ASSERT_THAT(found, AnyOf(Eq(begin.images), Eq(fresh))) << "operation " << operation;
        } else {
          ASSERT_EQ(found, fresh) << "was durable";
        }
      });
    }
    EXPECT_EQ(operation, 2 + 3 + 1);
  }
}

// ---- damage and refusal ----

TEST(BoardStore, OlderSetAfterDamageIsAFaultThatTheOperatorResets) {
  Bench bench;
  bench.store_models(Bench::images_of(1));
  bench.store_models(Bench::images_of(2));
  config::Slots slots = bench.store.durable;
  slots[1][config::kRecordHeaderBytes + 40] ^= 1;
  bench.store = config::PowerCutMedium(slots);
  bench.board.start();
  bench.put(0, {1, 0});
  bench.run(3);
  EXPECT_EQ(bench.session.download_model(5), image_of(kValve, 1)) << "the whole older set, of every chamber";
  EXPECT_EQ(bench.image().error_code, 0x6300);
  EXPECT_EQ(bench.image().fault_chamber, 0) << "the board's set, not a chamber's model";
  EXPECT_EQ(bench.session.read<std::uint8_t>(object::kStoredSet, 2), 2) << "fell back";
  bench.control(0x1);
  bench.run(2);
  EXPECT_EQ(bench.image().error_code, 0x6300);
  bench.control(0x9);
  bench.run(2);
  EXPECT_EQ(bench.image().error_code, 0);
}

TEST(BoardStore, LosingBothSlotsLeavesTheBoardReachableAndNamesIt) {
  Bench bench;
  bench.store_models(Bench::images_of(1));
  bench.store_models(Bench::images_of(2));
  config::Slots slots = bench.store.durable;
  for (auto& slot : slots) slot[config::kRecordHeaderBytes + 40] ^= 1;
  bench.store = config::PowerCutMedium(slots);
  bench.board.start();
  bench.tick();
  const auto emergencies = bench.take_emergencies();
  ASSERT_EQ(emergencies.size(), 1U);
  EXPECT_EQ(emergencies[0].code, 0x6300);
  EXPECT_EQ(emergencies[0].chamber, 0);
  for (std::uint8_t c = 0; c < kChambers; ++c) EXPECT_THAT(bench.session.download_model(c), IsEmpty());
  EXPECT_EQ(bench.session.read<std::uint8_t>(object::kStoredSet, 2), 3) << "lost";
  // and a new upload is stored as ever
  bench.session.upload_models(uploads_of(Bench::images_of(3)));
  bench.finish_storing();
  EXPECT_EQ(models_after_restart(bench.store.durable), Bench::images_of(3));
}

TEST(BoardStore, AnyDamagedByteGivesAWholeSetOrANamedFault) {
  Bench writer;
  writer.store_models(Bench::images_of(1));
  writer.store_models(Bench::images_of(2));
  const std::size_t used = config::kRecordHeaderBytes + kChambers * (4 + image_of(kValve).size());
  for (std::size_t slot = 0; slot < 2; ++slot) {
    for (std::size_t at = 0; at < used; ++at) {
      config::Slots slots = writer.store.durable;
      slots[slot][at] ^= 0x04;
      Bench bench;
      bench.store = config::PowerCutMedium(slots);
      bench.board.start();
      bench.tick();
      const auto crc = [&](std::uint8_t c) {
        return config::trailing_crc(bench.board.controller().active_image(c));
      };
      const std::uint32_t first = crc(0);
      for (std::uint8_t c = 1; c < kChambers; ++c) ASSERT_EQ(crc(c), first) << "a mixture, byte " << at;
      const bool newest = first == config::trailing_crc(image_of(kValve, 2));
      ASSERT_TRUE(newest || first == config::trailing_crc(image_of(kValve, 1)));
      ASSERT_TRUE(newest || bench.image().error_code == 0x6300) << "an older set without a word, byte " << at;
    }
  }
}

TEST(BoardStore, ModelThatThisFirmwareDoesNotTakeIsSkippedCountedAndNamed) {
  Bench bench;
  Bench::Images images = Bench::images_of(1);
  images[2][4] ^= 1;  // the schema's hash, of other firmware; its CRC with it
  const std::uint32_t crc = config::crc32(std::span(images[2]).first(images[2].size() - 4));
  for (std::size_t i = 0; i < 4; ++i)
    images[2][images[2].size() - 4 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
  bench.store_models(images);
  bench.board.start();
  bench.tick();
  EXPECT_THAT(bench.session.download_model(2), IsEmpty());
  EXPECT_EQ(bench.session.download_model(3), image_of(kValve, 1));
  EXPECT_EQ(bench.session.read<std::uint16_t>(object::kStoredSet, 4), 1);
  EXPECT_EQ(bench.session.read<std::uint32_t>(object::kStoredSet, 5), 0x211A00U);
  EXPECT_EQ(bench.image().error_code, 0);
}

/// The bytes of the model row of a chamber in the newest set; empty when there is none.
std::vector<std::uint8_t> stored_model(const config::Slots& slots, std::uint8_t chamber) {
  config::PowerCutMedium medium(slots);
  config::RecordStore store(medium);
  std::vector<std::uint8_t> body(config::kMaxBodyBytes);
  body.resize(store.load(body).size);
  config::RowReader rows(body);
  for (config::RecordRow row; rows.next(row);) {
    if (row.index == object::kActiveModel + chamber && row.sub == 0)
      return {row.value.begin(), row.value.end()};
  }
  return {};
}

TEST(BoardStore, ModelThatThisFirmwareDoesNotTakeIsKeptForTheOneThatDoesUntilAnotherComesIntoForce) {
  Bench::Images images = Bench::images_of(1);
  images[2][4] ^= 1;
  Bench bench;
  bench.store_models(images);
  bench.board.start();
  bench.storing = true;
  bench.tick();
  bench.session.write(object::kStore, 1, canopen::kSaveSignature);
  bench.session.upload_model(5, image_of(kValve, 6));
  bench.finish_storing();
  EXPECT_EQ(stored_model(bench.store.durable, 2), images[2]) << "after a save, and another chamber's model";
  EXPECT_EQ(stored_model(bench.store.durable, 5), image_of(kValve, 6));
  bench.session.upload_model(2, image_of(kValve, 3));
  bench.finish_storing();
  EXPECT_EQ(stored_model(bench.store.durable, 2), image_of(kValve, 3));
}

TEST(BoardStore, SavesThatFailedAreTheClientsToRepeatAndNoFaultThatStays) {
  Bench bench;
  bench.board.start();
  bench.storing = true;
  bench.store.refuses = true;
  for (int i = 0; i < 4; ++i) {
    EXPECT_THROW(bench.session.write(object::kStore, 1, canopen::kSaveSignature), host::client::SdoAbort);
  }
  bench.run(3);
  EXPECT_EQ(bench.image().error_code, 0);
  EXPECT_EQ(bench.image().store.phase, StorePhase::idle) << "nothing waits to be stored";
  EXPECT_EQ(bench.session.read<std::uint32_t>(object::kStoredSet, 6), 4U);
}

TEST(BoardStore, RefusingStoreIsAFaultUntilItWorksAgainAndTheModelsStay) {
  Bench bench;
  bench.board.start();
  bench.store.refuses = true;
  bench.session.upload_model(3, image_of(kValve, 1));
  bench.take();
  const auto attempt = [&] {  // one call composes, the next one fails
    bench.board.store_changed();
    bench.board.store_changed();
    bench.tick();
  };
  attempt();
  EXPECT_EQ(bench.session.read<std::uint8_t>(object::kStoredSet, 1), 2);
  attempt();
  EXPECT_EQ(bench.image().error_code, 0) << "twice may be chance";
  attempt();
  bench.tick();
  EXPECT_EQ(bench.image().error_code, 0x6300);
  EXPECT_EQ(bench.image().fault_chamber, 0);
  EXPECT_EQ(bench.session.read<std::uint32_t>(object::kStoredSet, 6), 3U);
  EXPECT_EQ(bench.session.download_model(3), image_of(kValve, 1));

  bench.session.upload_model(3, image_of(kValve, 2));
  bench.store.refuses = false;
  bench.finish_storing();
  while (bench.image().store.phase != StorePhase::idle) bench.finish_storing();
  bench.run(2 * safety::FaultRegister::kFlicker_ticks);
  EXPECT_EQ(bench.image().error_code, 0);
  EXPECT_EQ(models_after_restart(bench.store.durable)[3], image_of(kValve, 2));
}

TEST(BoardStore, NoTickWaitsForABusyMedium) {
  Bench bench;
  bench.store.patience = 1000;
  bench.board.start();
  bench.session.upload_models(uploads_of(Bench::images_of(1)));
  for (int i = 0; i < 500; ++i) {
    bench.board.store_changed();
    bench.tick();
  }
  EXPECT_EQ(bench.image().store.phase, StorePhase::writing);
  EXPECT_EQ(bench.store.operations, 0);
}

}  // namespace
}  // namespace plenum
