#include "host-sim/wire/candump.hpp"

#include <gtest/gtest.h>

namespace plenum::host::wire {
namespace {

CanFrame frame_of(std::uint32_t id, std::vector<std::uint8_t> bytes, bool extended = false) {
  CanFrame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size()), .extended = extended};
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

TEST(Candump, WritesWhatCandumpWrites) {
  EXPECT_EQ(candump_line(1'700'000'000'123'456, "can0", frame_of(0x181, {1, 2})),
            "(1700000000.123456) can0 181#0102");
  EXPECT_EQ(candump_line(12'345'678, "vcan0", frame_of(0x12, {}, true)),
            "(0000000012.345678) vcan0 00000012#");
  EXPECT_EQ(candump_line(0, "can1", {.id = 0x701, .length = 1, .remote = true}),
            "(0000000000.000000) can1 701#R1");
  EXPECT_EQ(candump_line(0, "can1", {.id = 0x701, .remote = true}), "(0000000000.000000) can1 701#R");
}

TEST(Candump, ReadsWhatItWrites) {
  for (const CanFrame& frame :
       {frame_of(0x000, {}), frame_of(0x7FF, {1, 2, 3, 4, 5, 6, 7, 0xFF}), frame_of(0x1FFFFFFF, {0xAB}, true),
        frame_of(0x5, {}, true), CanFrame{.id = 0x701, .length = 8, .remote = true}}) {
    const auto logged = parse_candump(candump_line(1'700'000'000'000'001, "slcan0", frame));
    ASSERT_TRUE(logged);
    EXPECT_EQ(logged->frame, frame);
    EXPECT_EQ(logged->time_us, 1'700'000'000'000'001U);
    EXPECT_EQ(logged->channel, "slcan0");
  }
}

TEST(Candump, WhatCandumpAddsBehindAFrameIsPassedOver) {
  ASSERT_TRUE(parse_candump("(1.000000) can0 181#01 R"));  // candump -x: received
  ASSERT_TRUE(parse_candump("(1.000000) can0 181#01\r"));
}

TEST(Candump, TellsWhereAReceiveBufferWasFull) {
  const std::string line = candump_line(1'000'000, "can0", kReceiveOverflow);
  EXPECT_EQ(line, "(0000000001.000000) can0 20000004#0001000000000000");
  ASSERT_TRUE(parse_candump(line));
  EXPECT_TRUE(parse_candump(line)->frames_missing);
  for (const char* other : {"(1.000000) can0 20000004#0010000000000000",  // error-passive
                            "(1.000000) can0 20000040#0001000000000000", "(1.000000) can0 00000004#0001"}) {
    ASSERT_TRUE(parse_candump(other)) << other;
    EXPECT_FALSE(parse_candump(other)->frames_missing) << other;
  }
}

TEST(Candump, TellsCanFdFramesAndErrorsOfTheBusFromClassicFrames) {
  EXPECT_TRUE(parse_candump("(1.000000) can0 1FFFFFFF#00")->classic);
  for (const std::string& line :
       {std::string("(1.000000) can0 20000004#0000000000000000"), std::string("(1.000000) can0 181##0"),
        "(1.000000) can0 00000181##3" + std::string(128, 'A')}) {
    const auto logged = parse_candump(line);
    ASSERT_TRUE(logged) << line;
    EXPECT_FALSE(logged->classic) << line;
    EXPECT_FALSE(logged->frames_missing) << line;
    EXPECT_EQ(logged->time_us, 1'000'000U);
  }
  EXPECT_FALSE(parse_candump("(1.000000) can0 181##3" + std::string(130, 'A')));
}

TEST(Candump, WhatIsNoFrameIsNone) {
  for (const char* line : {"",
                           "(1.000000)",
                           "(1.000000) can0",
                           "(1.000000) can0 181",
                           "1.000000 can0 181#",
                           "(1.0) can0 181#01",
                           "(x.000000) can0 181#01",
                           "(1.000000) can0 18#01",
                           "(1.000000) can0 0181#01",
                           "(1.000000) can0 800#01",
                           "(1.000000) can0 40000004#0000000000000000",
                           "(1.000000) can0 20000004#000",
                           "(1.000000) can0 181#1",
                           "(1.000000) can0 181#0G",
                           "(1.000000) can0 181#010203040506070809",
                           "(1.000000) can0 181##",
                           "(1.000000) can0 181##00",
                           "(1.000000) can0 181##0G1",
                           "(1.000000) can0 181#R9",
                           "(1.000000) can0 181#R11",
                           "(1.000000)can0 181#01",
                           "(1.000000)  181#01",
                           "(99999999999999999999.000000) can0 181#01",
                           "(18446744073709.551616) can0 181#01"}) {
    EXPECT_FALSE(parse_candump(line)) << line;
  }
}

}  // namespace
}  // namespace plenum::host::wire
