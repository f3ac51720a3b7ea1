// The simulated bus has one bit rate: what LSS may tell a board about it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "host-sim/rig/rig.hpp"
#include "host-sim/rig/standard_rigs.hpp"

namespace plenum::host::rig {
namespace {

/// Returns the answer of board 1 to an LSS frame; empty when it gives none in 0.1 s.
std::vector<std::uint8_t> answer(Rig& rig, ports::SimulatedCanPort& master,
                                 const std::vector<std::uint8_t>& request) {
  plenum::ports::CanFrame frame;
  frame.id = 0x7E5;
  frame.length = 8;
  std::copy(request.begin(), request.end(), frame.data.begin());
  master.send(frame);
  for (int i = 0; i < 10; ++i) {
    rig.run_until(rig.now_ns() + 10'000'000);
    while (master.receive(frame)) {
      if (frame.id == 0x7E4) return {frame.data.begin(), frame.data.end()};
    }
  }
  return {};
}

RigConfig rig_at(std::uint32_t bit_rate, const std::filesystem::path& folder) {
  RigConfig config = mpye_rig({.chambers = 1});
  config.bus.bit_rate = bit_rate;
  config.board.at(0).store = folder;
  return config;
}

TEST(BitRate, IsTheOneOfTheBusOrRefusedAndAStoredOneMustBeTheBus) {
  using ::testing::ElementsAre;
  using ::testing::HasSubstr;
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "plenum-bit-rate";
  std::filesystem::remove_all(folder);
  {
    Rig rig(rig_at(250'000, folder));
    ports::SimulatedCanPort& master = rig.attach("master");
    answer(rig, master, {0x04, 1});
    EXPECT_THAT(answer(rig, master, {0x13, 0, 0}), ElementsAre(0x13, 1, 0, 0, 0, 0, 0, 0)) << "1 Mbit/s";
    EXPECT_THAT(answer(rig, master, {0x13, 0, 3}), ElementsAre(0x13, 0, 0, 0, 0, 0, 0, 0)) << "250 kbit/s";
    EXPECT_THAT(answer(rig, master, {0x17}), ElementsAre(0x17, 0, 0, 0, 0, 0, 0, 0));
  }
  EXPECT_EQ(Rig(rig_at(250'000, folder)).board(0).lss().bit_rate_kbit, 250);
  try {
    Rig rig(rig_at(1'000'000, folder));
    FAIL() << "a board that cannot hear its bus";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("board 1 was told by LSS to run at 250000 bit/s"));
    EXPECT_THAT(error.what(), HasSubstr("1000000 bit/s"));
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace plenum::host::rig
