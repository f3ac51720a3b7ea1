// What the board's log holds of a chamber that it regulates.
#include <gtest/gtest.h>

#include "firmware/canopen/objects.hpp"
#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

namespace object = canopen::object;

std::uint16_t rows(Bench& bench) {
  return bench.session.read<std::uint16_t>(object::kCapture, 5);
}

TEST(CaptureLog, HasARowForEachTickInWhichTheValvesAreDriven) {
  Bench bench;
  bench.store_models();
  bench.board.start();
  bench.put(0, {1, 0});
  bench.control(0x1);
  bench.run(20);
  EXPECT_EQ(rows(bench), 0) << "disabled";
  bench.streaming = true;
  bench.control(0x3);
  bench.run(2);
  const std::uint16_t before = rows(bench);
  EXPECT_GT(before, 0) << "hold";
  bench.run(7);
  EXPECT_EQ(rows(bench), before + 7);
  bench.control(0x7);
  bench.run(10);
  EXPECT_EQ(rows(bench), before + 17) << "active";
  bench.control(0x1);
  bench.run(30);
  EXPECT_EQ(rows(bench), before + 17) << "disabled again";
}

TEST(CaptureLog, KeepsWhatLedToAFaultThoughTheBoardHolds) {
  Bench bench;
  bench.store_models();
  bench.board.start();
  bench.put(0, {1, 0});
  bench.climb();
  auto& supply = bench.forced[2 * config::kChambers];
  supply = ports::AnalogReading{4.9F, true};  // too low
  for (int i = 0; i < 40 && bench.state() != safety::State::fault_hold; ++i) bench.run(1);
  ASSERT_EQ(bench.state(), safety::State::fault_hold);
  const std::uint16_t then = rows(bench);
  bench.run(100);
  EXPECT_EQ(rows(bench), then) << "the valves are driven, to hold";
  supply = ports::AnalogReading{6.2F, true};
  bench.run(30);
  EXPECT_EQ(rows(bench), then) << "the fault is latched";
  bench.session.reset_fault();
  bench.climb();
  EXPECT_GT(rows(bench), then) << "after the reset it goes on";
}

TEST(CaptureLog, HasARowForEachTickOfExcitation) {
  Bench bench;
  bench.session.write(object::kControlMode, 0, std::int8_t{-1});
  bench.put(0, {1, 0});
  bench.climb();
  const std::uint16_t before = rows(bench);
  bench.run(25);
  EXPECT_EQ(rows(bench), before + 25);
}

}  // namespace
}  // namespace plenum
