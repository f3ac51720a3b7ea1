#include "host-sim/wire/slcan.hpp"

#include <gtest/gtest.h>

namespace plenum::host::wire {
namespace {

CanFrame frame_of(std::uint32_t id, std::vector<std::uint8_t> bytes, bool extended = false) {
  CanFrame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size()), .extended = extended};
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

// The examples of LAWICEL's manual: t10021133, T0000010021133, r1002, R000001002.

TEST(Slcan, WritesFramesAsTheManualDoes) {
  EXPECT_EQ(slcan_line(frame_of(0x100, {0x11, 0x33})), "t10021133\r");
  EXPECT_EQ(slcan_line(frame_of(0x100, {0x11, 0x33}, true)), "T0000010021133\r");
  EXPECT_EQ(slcan_line({.id = 0x100, .length = 2, .remote = true}), "r1002\r");
  EXPECT_EQ(slcan_line({.id = 0x100, .length = 2, .extended = true, .remote = true}), "R000001002\r");
}

TEST(Slcan, ReadsFramesAsTheManualWritesThem) {
  EXPECT_EQ(parse_slcan("t10021133"), frame_of(0x100, {0x11, 0x33}));
  EXPECT_EQ(parse_slcan("T0000010021133"), frame_of(0x100, {0x11, 0x33}, true));
  EXPECT_EQ(parse_slcan("r1002"), (CanFrame{.id = 0x100, .length = 2, .remote = true}));
  EXPECT_EQ(parse_slcan("t0800"), frame_of(0x80, {}));
}

TEST(Slcan, ATimeStampIsPassedOver) {
  EXPECT_EQ(parse_slcan("t100211330A1B"), frame_of(0x100, {0x11, 0x33}));
  EXPECT_EQ(parse_slcan("r10020A1B"), (CanFrame{.id = 0x100, .length = 2, .remote = true}));
}

TEST(Slcan, WhatIsNoFrameIsNone) {
  for (const char* line : {"", "z", "Z", "V1013", "t", "t100", "t1009", "t100211", "t10021133A", "t8000",
                           "t1-00", "T200000000", "T10021133", "t10021G33", "x1000", "F00"}) {
    EXPECT_FALSE(parse_slcan(line)) << line;
  }
}

TEST(Slcan, NineBitRatesHaveADigit) {
  EXPECT_EQ(slcan_rate(10'000), '0');
  EXPECT_EQ(slcan_rate(500'000), '6');
  EXPECT_EQ(slcan_rate(1'000'000), '8');
  EXPECT_EQ(slcan_rate(83'333), std::nullopt);
}

}  // namespace
}  // namespace plenum::host::wire
