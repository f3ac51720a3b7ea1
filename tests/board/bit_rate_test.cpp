// Which bit rate a board's interface is to run at, and from where the board knows it.
#include "board/bit_rate.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
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

drivers::CanInterface running_at(std::optional<std::uint32_t> bit_rate) {
  return {.up = true, .controller = true, .bit_rate = bit_rate};
}

TEST(BitRateOfABoard, IsTheStatedOneElseTheStoredOneElseThatWhichThereIsElseTheFastest) {
  const LssSettings told{.node_id = 0, .bit_rate_kbit = 500};
  const drivers::CanInterface set_up = running_at(125'000);
  EXPECT_EQ(wanted_bit_rate(stating(250), told, set_up).bit_s, 250'000U);
  EXPECT_EQ(wanted_bit_rate(stating({}), told, set_up).bit_s, 500'000U);
  EXPECT_EQ(wanted_bit_rate(stating({}), LssSettings{}, set_up).bit_s, 125'000U);
  EXPECT_EQ(wanted_bit_rate(stating({}), LssSettings{}, running_at({})).bit_s, 1'000'000U);
  const LssSettings none_of_cia_305{.node_id = 0, .bit_rate_kbit = 501};
  EXPECT_EQ(wanted_bit_rate(stating({}), none_of_cia_305, set_up).bit_s, 125'000U);
}

TEST(BitRateOfABoard, AnotherOneIsToldWithBothAndWhoSaysSo) {
  const BitRate wanted{1'000'000, "can.bit_rate_kbit"};
  EXPECT_EQ(bit_rate_trouble(running_at(1'000'000), wanted, "can0"), "");
  EXPECT_EQ(bit_rate_trouble(running_at(1'004'000), wanted, "can0"), "")
      << "as near as the clock comes to it";
  EXPECT_EQ(bit_rate_trouble({.up = true, .controller = false, .bit_rate = {}}, wanted, "vcan0"), "")
      << "one that can have none";
  EXPECT_EQ(
      bit_rate_trouble(running_at(500'000), wanted, "can0"),
      "can:can0: runs at 500 kbit/s, expected the 1000 of can.bit_rate_kbit (systemctl start plenumd-bus)");
  EXPECT_NE(bit_rate_trouble(running_at(1'013'000), wanted, "can0"), "");
  EXPECT_NE(bit_rate_trouble(running_at({}), wanted, "can0"), "");
  EXPECT_EQ(bit_rate_trouble(running_at(83'333), {125'000, "what LSS has stored"}, "can0"),
            "can:can0: runs at 83.333 kbit/s, expected the 125 of what LSS has stored (systemctl start "
            "plenumd-bus)");
}

TEST(BitRateOfABoard, OfAnInterfaceThatHasNoneOrIsNotThereNothingIsSet) {
  config::BoardFile board = stating(500);
  board.interface = "lo";
  EXPECT_EQ(set_bit_rate(board), "");
  board.interface = "plenum-none";
  EXPECT_EQ(set_bit_rate(board), "can:plenum-none: is not there yet: nothing is set");
}

TEST(BitRateOfABoard, LssMayGiveThoseThatTheControllerCanRunAt) {
  config::BoardFile any = stating({});
  any.settings.node.bit_rates = 0x1DF;
  drivers::CanInterface controller = running_at(500'000);
  EXPECT_EQ(rates_for_lss(any, controller), 0x1DF) << "nothing is stated of it";
  controller.only = {125'000, 500'000, 1'000'000};
  EXPECT_EQ(rates_for_lss(any, controller), 1U << 0 | 1U << 2 | 1U << 4) << "rows of table 0 of CiA 305";
  EXPECT_EQ(rates_for_lss(any, std::nullopt), 0x1DF) << "none there yet";
  controller.controller = false;
  EXPECT_EQ(rates_for_lss(any, controller), 0x1DF) << "a vcan";
}

struct StoredLss : ::testing::Test {
  std::filesystem::path folder;
  void SetUp() override {
    std::string name = ::testing::TempDir() + "plenum-lss-XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
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

TEST_F(StoredLss, IsNoneWhereNothingWasStoredAndNoFileIsMade) {
  EXPECT_EQ(stored_lss(folder), LssSettings{});
  EXPECT_EQ(files(), 0U);
  EXPECT_EQ(stored_lss(folder / "none"), LssSettings{});
}

TEST_F(StoredLss, IsNotTakenForNoneWhereItIsDamaged) {
  store(kBody);
  for (const char* slot : {"slot-a.bin", "slot-b.bin"})
    std::ofstream(folder / slot) << "no set of parameters";
  EXPECT_EQ(stored_lss(folder), std::nullopt);
}

TEST_F(StoredLss, FollowsNoLinkAndWaitsForNoPipe) {
  store(kBody);
  const std::filesystem::path other = folder / "other";
  std::filesystem::create_directory(other);
  for (const char* slot : {"slot-a.bin", "slot-b.bin"})
    std::filesystem::create_symlink(folder / slot, other / slot);
  EXPECT_EQ(stored_lss(other), std::nullopt);
  for (const char* slot : {"slot-a.bin", "slot-b.bin"}) {
    std::filesystem::remove(other / slot);
    ASSERT_EQ(::mkfifo((other / slot).c_str(), 0600), 0);
  }
  EXPECT_EQ(stored_lss(other), std::nullopt);
}

}  // namespace
}  // namespace plenum::board
