// Objects 2300h and 2301h: the log of the last ticks.
#include <gtest/gtest.h>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

void record(Bench& bench, std::uint32_t first, std::uint32_t last) {
  for (std::uint32_t tick = first; tick <= last; ++tick) bench.recorder.write(tick, false, {});
}

TEST(Capture, RollsFromTheStart) {
  Bench bench;
  record(bench, 1, 5);
  EXPECT_EQ(bench.answer("605 40 00 23 01 00 00 00 00"), "585 4F 00 23 01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 00 23 03 00 00 00 00"), "585 4B 00 23 03 00 04 00 00") << "1024 ticks";
  EXPECT_EQ(bench.answer("605 40 00 23 04 00 00 00 00"), "585 4F 00 23 04 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 00 23 05 00 00 00 00"), "585 4B 00 23 05 05 00 00 00");
}

TEST(Capture, RecordsTheTicksAskedForAndFreezes) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 2B 00 23 03 03 00 00 00"), "585 60 00 23 03 00 00 00 00");
  EXPECT_EQ(bench.answer("605 2F 00 23 01 02 00 00 00"), "585 60 00 23 01 00 00 00 00");
  record(bench, 1, 2);
  EXPECT_EQ(bench.answer("605 40 00 23 04 00 00 00 00"), "585 4F 00 23 04 01 00 00 00");
  EXPECT_EQ(bench.answer("605 2B 00 23 03 09 00 00 00"), "585 80 00 23 03 22 00 00 08")
      << "not while it records";
  record(bench, 3, 9);
  EXPECT_EQ(bench.answer("605 40 00 23 04 00 00 00 00"), "585 4F 00 23 04 02 00 00 00");
  EXPECT_EQ(bench.answer("605 40 00 23 05 00 00 00 00"), "585 4B 00 23 05 03 00 00 00");
}

TEST(Capture, RefusesWhatIsOutOfRange) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 2F 00 23 01 03 00 00 00"), "585 80 00 23 01 31 00 09 06");
  EXPECT_EQ(bench.answer("605 2F 00 23 02 08 00 00 00"), "585 80 00 23 02 31 00 09 06");
  EXPECT_EQ(bench.answer("605 2B 00 23 03 00 00 00 00"), "585 80 00 23 03 32 00 09 06");
  EXPECT_EQ(bench.answer("605 2B 00 23 03 01 04 00 00"), "585 80 00 23 03 31 00 09 06") << "1025 ticks";
  EXPECT_EQ(bench.answer("605 2F 00 23 04 02 00 00 00"), "585 80 00 23 04 02 00 01 06") << "read only";
}

TEST(Capture, IsNotReadWhileItGoesOn) {
  Bench bench;
  record(bench, 1, 5);
  EXPECT_EQ(bench.answer("605 40 01 23 00 00 00 00 00"), "585 80 01 23 00 22 00 00 08");
  bench.answer("605 2F 00 23 01 02 00 00 00");
  EXPECT_EQ(bench.answer("605 40 01 23 00 00 00 00 00"), "585 80 01 23 00 22 00 00 08");
}

}  // namespace
}  // namespace plenum::canopen
