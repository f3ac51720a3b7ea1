// Set points that stop, have not come yet, or are of yesterday: what a chamber follows meanwhile, and when that is a fault.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ios>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using safety::State;
using ::testing::IsEmpty;
namespace object = canopen::object;

TEST(BoardFault, SetPointStreamLostByItsEventTimerIsToldByEveryObjectInTheSameTick) {
  Bench bench;
  bench.store_models();
  bench.board.start();
  bench.session.write(object::kRpdoCommunication, 5, std::uint16_t{30});  // before the board's own 100 ms
  bench.put(0, {1, 0});
  bench.climb();
  bench.run(50);
  bench.take();
  bench.streaming = false;
  int ticks = 0;
  for (; bench.image().error_code == 0 && ticks < 20; ++ticks) {
    ASSERT_THAT(bench.take_emergencies(), IsEmpty()) << "tick " << ticks << " after the last set point";
    bench.tick();
  }
  EXPECT_LE(ticks, 5);
  EXPECT_EQ(bench.image().error_code, 0x8250);
  EXPECT_EQ(bench.state(), State::fault_reaction);
  EXPECT_EQ(bench.take_emergencies().size(), 1U);
}

TEST(BoardFault, AResetRightBehindALostStreamIsTaken) {
  for (const bool rises_within_a_tick : {false, true}) {
    Bench bench;
    bench.go_active(300.0);
    bench.streaming = false;
    bench.run(20);
    ASSERT_EQ(bench.image().error_code, 0x8250);
    ASSERT_EQ(bench.state(), State::fault_disabled);
    if (rises_within_a_tick) bench.control(0);
    bench.control(8);
    bench.tick();
    EXPECT_EQ(bench.image().error_code, 0) << "nobody asks for ACTIVE, and no set point is missing any more";
    EXPECT_EQ(bench.state(), State::init);
  }
}

/// HOLD at 200 kPa; the set points of all chambers are 500 kPa, and of yesterday.
struct Yesterday : Bench {
  Yesterday() {
    store_models();
    board.start();
    put(0, {1, 0});
    setpoint_kPa = 500.0;
    streaming = true;
    run(5);
    streaming = false;
    for (std::size_t c = 0; c < kChambers; ++c) {
      session.write(object::of_module(object::kHoldSetpoint, c), 1, std::int16_t{2000});
    }
    run(20);
    for (const std::uint16_t word : Words{0x1, 0x3}) {
      control(word);
      run(50);
    }
  }
};

TEST(BoardFault, ActiveGoesOnAsHoldUntilAFreshSetPointComes) {
  Yesterday bench;
  bench.control(0x7);
  for (int tick = 0; tick < 9; ++tick) {
    bench.tick();
    ASSERT_EQ(bench.state(), State::active);
    ASSERT_EQ(bench.image().chamber[3].demand_Pa, 200e3F) << "tick " << tick;
  }
  bench.setpoint_kPa = 400.0;
  bench.streaming = true;
  bench.run(1);
  EXPECT_EQ(bench.image().chamber[3].demand_Pa, 400e3F);
  bench.run(50);
  EXPECT_EQ(bench.state(), State::active);

  bench.control(0x3);  // the stream goes on: it is fresh when ACTIVE comes
  bench.run(50);
  bench.control(0x7);
  bench.run(1);
  EXPECT_EQ(bench.image().chamber[3].demand_Pa, 400e3F);
}

TEST(BoardFault, ActiveWithoutAnySetPointEndsWhereTheWatchdogDoesAndHasMovedNothing) {
  Yesterday bench;
  bench.control(0x7);
  int ticks = 0;
  for (; bench.image().error_code == 0 && ticks < 50; ++ticks) {
    EXPECT_LE(bench.image().chamber[3].demand_Pa, 200e3F) << "tick " << ticks;
    bench.tick();
  }
  EXPECT_EQ(bench.image().error_code, 0x8250);
  EXPECT_LE(ticks, bench_settings().board.setpoint_watchdog_ticks + 2);
}

TEST(BoardFault, AChamberWhoseSetPointHasNotComeHoldsWhileOthersFollowTheirs) {
  Yesterday bench;
  const auto stream_the_first_four = [&] {
    bench.put(0x200 + Bench::kNode, {0xA0, 0x0F, 0xA0, 0x0F, 0xA0, 0x0F, 0xA0, 0x0F});  // 400 kPa
    bench.put(0x80, {});
    bench.tick();
  };
  bench.control(0x7);
  for (int tick = 0; tick < 30; ++tick) {
    stream_the_first_four();
  }
  EXPECT_EQ(bench.state(), State::active);
  EXPECT_EQ(bench.image().chamber[0].demand_Pa, 400e3F);
  EXPECT_EQ(bench.image().chamber[7].demand_Pa, 200e3F) << "500 kPa were asked for by nobody who is here";
  bench.session.write(object::of_module(object::kSetpoint, 7), 1, std::int16_t{3000});
  stream_the_first_four();
  EXPECT_EQ(bench.image().chamber[7].demand_Pa, 300e3F) << "one that is written is of now";
}

TEST(BoardFault, AChangeOfTheControlModeMakesNoSetPointNew) {
  Yesterday bench;
  const auto mode = [&](int value) {
    bench.session.write(object::kControlMode, 0, static_cast<std::int8_t>(value));
  };
  mode(-1);
  for (int tick = 0; tick < 20; ++tick) {
    bench.put(0x80, {});
    bench.tick();
  }
  mode(4);
  bench.control(0x7);
  bench.run(3);
  EXPECT_EQ(bench.state(), State::active);
  EXPECT_EQ(bench.image().chamber[3].demand_Pa, 200e3F);
}

TEST(BoardFault, OneStreamOfSetPointsDoesNotVouchForAnother) {
  for (const std::uint32_t lost : {0x200U, 0x300U}) {
    Bench bench;
    bench.store_models();
    bench.board.start();
    for (const std::uint16_t pdo :
         {object::kRpdoCommunication, std::uint16_t{object::kRpdoCommunication + 1}})
      bench.session.write(pdo, 5, std::uint16_t{0});  // no event timer: the watchdog alone
    bench.put(0, {1, 0});
    bench.climb();
    bench.run(50);
    bench.streaming = false;
    int ticks = 0;
    for (; bench.image().error_code == 0 && ticks < 50; ++ticks) {
      bench.put((0x500U - lost) + Bench::kNode, {0xD0, 0x07, 0xD0, 0x07, 0xD0, 0x07, 0xD0, 0x07});
      bench.put(0x80, {});
      bench.tick();
    }
    EXPECT_EQ(bench.image().error_code, 0x8250) << std::hex << lost;
    EXPECT_LE(ticks, bench_settings().board.setpoint_watchdog_ticks + 1);
    EXPECT_EQ(bench.state(), State::fault_reaction);
  }
}

TEST(BoardFault, AStreamThatNeverCameIsNotMissed) {
  Bench bench;
  bench.store_models();
  bench.board.start();
  bench.put(0, {1, 0});
  for (const std::uint16_t word : Words{0x1, 0x3, 0x7, 0x7, 0x7}) {
    bench.control(word);
    for (int tick = 0; tick < 30; ++tick) {
      bench.put(0x200 + Bench::kNode, {0xD0, 0x07, 0xD0, 0x07, 0xD0, 0x07, 0xD0, 0x07});
      bench.put(0x80, {});
      bench.tick();
    }
  }
  EXPECT_EQ(bench.state(), State::active);
  EXPECT_EQ(bench.image().error_code, 0);
}

}  // namespace
}  // namespace plenum
