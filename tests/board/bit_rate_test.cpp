// Which bit rate a board's interface is to run at, and from where the board knows it.
#include "board/bit_rate.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "board/drivers/file_store.hpp"
#include "firmware/config/record_store.hpp"

namespace plenum::board {
namespace {

using plenum::config::LssSettings;

config::BoardFile stating(std::optional<std::uint16_t> kbit) {
  config::BoardFile board;
  board.interface = "can0";
  board.bit_rate_kbit = kbit;
  return board;
}

TEST(BitRateOfABoard, IsTheStatedOneElseTheStoredOneElseTheFastest) {
  EXPECT_EQ(wanted_bit_rate(stating(250), LssSettings{.bit_rate_kbit = 500}).kbit, 250U);
  EXPECT_EQ(wanted_bit_rate(stating({}), LssSettings{.bit_rate_kbit = 500}).kbit, 500U);
  EXPECT_EQ(wanted_bit_rate(stating({}), LssSettings{}).kbit, 1000U);
  EXPECT_EQ(wanted_bit_rate(stating({}), LssSettings{.bit_rate_kbit = 501}).kbit, 1000U) << "no rate of CiA 305";
}

TEST(BitRateOfABoard, AnotherOneIsToldWithBothAndWhoSaysSo) {
  const BitRate wanted = wanted_bit_rate(stating(1000), {});
  const auto running_at = [](std::optional<std::uint32_t> bit_rate) {
    return drivers::CanInterface{.up = true, .controller = true, .bit_rate = bit_rate};
  };
  EXPECT_EQ(bit_rate_trouble(running_at(1'000'000), wanted, "can0"), "");
  EXPECT_EQ(bit_rate_trouble({.up = true, .controller = false, .bit_rate = {}}, wanted, "vcan0"), "") << "one that can have none";
  EXPECT_EQ(bit_rate_trouble(running_at(500'000), wanted, "can0"),
            "can:can0: runs at 500 kbit/s, expected the 1000 of can.bit_rate_kbit, which the service sets when it starts");
  EXPECT_EQ(bit_rate_trouble(running_at({}), wanted, "can0").rfind("can:can0: runs at 0 kbit/s", 0), 0U);
  EXPECT_EQ(bit_rate_trouble(running_at(83'333), wanted_bit_rate(stating({}), LssSettings{.bit_rate_kbit = 125}), "can0"),
            "can:can0: runs at 83.333 kbit/s, expected the 125 of what LSS has stored, which the service sets when it starts");
}

TEST(BitRateOfABoard, OfAnInterfaceThatHasNoneNothingIsDone) {
  config::BoardFile loopback = stating(500);
  loopback.interface = "lo";
  EXPECT_EQ(set_bit_rate(loopback), "");
}

TEST(BitRateOfABoard, AnInterfaceThatIsNotThereIsNamed) {
  config::BoardFile none = stating(500);
  none.interface = "plenum-none";
  try {
    set_bit_rate(none);
    FAIL() << "no failure";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "can:plenum-none: bit rate: no such interface, expected the kernel's answer");
  }
}

struct StoredLss : ::testing::Test {
  std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "plenum-stored-lss";
  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directory(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
  }
  void store(std::span<const std::uint8_t> body) const {
    drivers::FileStore files(folder);
    plenum::config::RecordStore record(files);
    std::vector<std::uint8_t> room(plenum::config::kMaxBodyBytes);
    record.load(room);
    record.begin(body);
    auto result = ports::StoreResult::busy;
    while (result == ports::StoreResult::busy) result = record.step();
    ASSERT_EQ(result, ports::StoreResult::done);
  }
};

// Rows: u16 index, u8 sub-index, u8 length, value.
constexpr std::array<std::uint8_t, 11> kBody = {0, 0, 1, 1, 9, 0, 0, 2, 2, 0xF4, 0x01};

TEST_F(StoredLss, IsReadFromTheSlotsOfAnother) {
  store(kBody);
  EXPECT_EQ(stored_lss(folder), (LssSettings{.node_id = 9, .bit_rate_kbit = 500}));
}

TEST_F(StoredLss, IsNothingWhereNothingWasStoredAndNoFileIsMade) {
  EXPECT_EQ(stored_lss(folder), LssSettings{});
  EXPECT_EQ(files(), 0U);
  EXPECT_EQ(stored_lss(folder / "none"), LssSettings{});
}

TEST_F(StoredLss, FollowsNoLinkAndWaitsForNoPipe) {
  store(kBody);
  const std::filesystem::path other = folder / "other";
  std::filesystem::create_directory(other);
  for (const char* slot : {"slot-a.bin", "slot-b.bin"}) std::filesystem::create_symlink(folder / slot, other / slot);
  EXPECT_EQ(stored_lss(other), LssSettings{});
  for (const char* slot : {"slot-a.bin", "slot-b.bin"}) {
    std::filesystem::remove(other / slot);
    ASSERT_EQ(::mkfifo((other / slot).c_str(), 0600), 0);
  }
  EXPECT_EQ(stored_lss(other), LssSettings{});
}

}  // namespace
}  // namespace plenum::board
