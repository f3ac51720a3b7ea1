// NMT, heartbeat and SYNC.
#include <gtest/gtest.h>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

TEST(Network, BootsUpIntoPreOperational) {
  ProcessImage image;
  FakeDesk desk;
  config::SettingsDesk settings;
  telemetry::Recorder recorder;
  Node node(Config{.node_id = 5}, image, desk, settings, recorder);
  ports::CanFrame frame;
  ASSERT_TRUE(node.next_frame(frame));
  EXPECT_EQ(text_of(frame), "705 00");
  EXPECT_FALSE(node.next_frame(frame));
  EXPECT_EQ(node.state(), NmtState::pre_operational);
}

TEST(Network, FollowsNmtCommandsForItselfAndForAll) {
  Bench bench;
  bench.send("000 01 05");
  EXPECT_EQ(bench.node.state(), NmtState::operational);
  bench.send("000 02 00");
  EXPECT_EQ(bench.node.state(), NmtState::stopped);
  bench.send("000 80 05");
  EXPECT_EQ(bench.node.state(), NmtState::pre_operational);
  for (const char* foreign : {"000 01 06", "000 01", "000 01 05 00", "000 07 05", "000"}) {
    bench.send(foreign);
    EXPECT_EQ(bench.node.state(), NmtState::pre_operational) << foreign;
  }
}

TEST(Network, IsSilentToSdoWhileStopped) {
  Bench bench;
  bench.send("000 02 05");
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "");
  bench.send("000 80 05");
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF");
}

TEST(Network, BeatsWithItsStateInEveryPeriod) {
  Bench bench;
  bench.tick(99);
  EXPECT_EQ(bench.drain(), Frames{});
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"705 7F"}) << "1000 ms by default";
  bench.answer("605 2B 17 10 00 32 00 00 00");  // 50 ms
  bench.send("000 02 05");
  for (int i = 0; i < 10; ++i) {
    bench.tick(4);
    EXPECT_EQ(bench.drain(), Frames{}) << i;
    bench.tick();
    EXPECT_EQ(bench.drain(), Frames{"705 04"}) << i;
  }
}

TEST(Network, KeepsTheMeanPeriodOfAHeartbeatThatIsNoMultipleOfTheTick) {
  Bench bench;
  bench.answer("605 2B 17 10 00 19 00 00 00");  // 25 ms
  std::size_t beats = 0;
  for (int i = 0; i < 100; ++i) {
    bench.tick();
    beats += bench.drain().size();
  }
  EXPECT_EQ(beats, 40U) << "in 1000 ms";
}

TEST(Network, ResetsItsCommunicationAndLeavesTheProcessAlone) {
  Bench bench;
  bench.answer("605 2B 17 10 00 32 00 00 00");
  bench.answer("605 2B 40 60 00 07 00 00 00");
  bench.answer("605 40 08 10 00 00 00 00 00");  // a transfer under way
  bench.send("000 82 05");
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "") << "nobody is there before the tick";
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"705 00"});
  EXPECT_EQ(bench.node.state(), NmtState::pre_operational);
  EXPECT_EQ(bench.image.control_word, 7);
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 E8 03 00 00");
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 80 00 00 00 01 00 04 05")
      << "no segment goes on";
}

TEST(Network, ResetsTheNodeToWhatTheBusHasNotWritten) {
  Bench bench;
  bench.answer("605 2B 40 60 00 07 00 00 00");
  bench.answer("605 2B 80 63 01 E8 03 00 00");
  bench.answer("605 2F 43 60 00 FF 00 00 00");
  bench.answer("605 23 13 23 01 09 00 00 00");
  bench.image.status_word = 0x000F;
  EXPECT_EQ(bench.image.chamber[3].excitation.seed, 9U);
  EXPECT_EQ(bench.image.control_mode, ControlMode::excitation);
  bench.send("000 81 00");
  EXPECT_EQ(bench.image.control_word, 0) << "at once: the board goes to INIT";
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{}) << "ACTIVE still";
  EXPECT_EQ(bench.image.chamber[3].excitation.seed, 9U);
  bench.image.status_word = 0x0008;
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"705 00"});
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 0.0F);
  EXPECT_EQ(bench.image.chamber[3].excitation.seed, 1U);
  EXPECT_EQ(bench.image.control_mode, ControlMode::pressure_closed_loop);
  EXPECT_EQ(bench.image.status_word, 0x0008) << "the controller's to say";
}

TEST(Network, ForgetsWithItsResetWhatAMasterHasBegunAndKeepsAFrozenLog) {
  Bench bench;
  bench.desk.staged[2] = {1, 2, 3};
  bench.answer("605 23 21 21 01 07 00 00 00");  // an upload session
  bench.answer("605 2F 00 23 02 03 00 00 00");  // the log of chamber 4 ...
  bench.answer("605 2B 00 23 03 02 00 00 00");  // ... of two ticks
  bench.answer("605 2F 00 23 01 01 00 00 00");
  bench.send("000 81 05");
  bench.tick();
  bench.drain();
  EXPECT_TRUE(bench.desk.staged[2].empty());
  EXPECT_EQ(bench.answer("605 40 21 21 01 00 00 00 00"), "585 43 21 21 01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 00 23 02 00 00 00 00"), "585 4F 00 23 02 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 00 23 03 00 00 00 00"), "585 4B 00 23 03 00 04 00 00");
  EXPECT_EQ(bench.answer("605 40 00 23 04 00 00 00 00"), "585 4F 00 23 04 02 00 00 00") << "for who reads it";
  bench.answer("605 2F 00 23 01 02 00 00 00");  // record
  bench.send("000 81 05");
  bench.tick();
  bench.drain();
  EXPECT_EQ(bench.answer("605 40 00 23 04 00 00 00 00"), "585 4F 00 23 04 00 00 00 00") << "rolls on";
}

TEST(Network, LeavesBit31OfTheSyncIdentifierAlone) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 23 05 10 00 81 00 00 80"), "585 60 05 10 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 05 10 00 00 00 00 00"), "585 43 05 10 00 81 00 00 00");
  EXPECT_EQ(bench.answer("605 23 05 10 00 80 00 00 40"), "585 80 05 10 00 30 00 09 06") << "no SYNC producer";
}

TEST(Network, ListensToTheSyncIdentifierItIsGiven) {
  Bench bench;
  bench.answer("605 23 05 10 00 81 00 00 00");
  bench.send("000 01 05");
  bench.send("205 E8 03 E8 03 E8 03 E8 03");
  bench.send("080");
  EXPECT_EQ(bench.image.setpoint_count, 0U);
  bench.send("081");
  EXPECT_EQ(bench.image.setpoint_count, 1U);
}

TEST(Emergency, TellsOfPdosAndSyncsThatDoNotFitForTenSecondsFromTheLastOn) {
  Bench bench(true);
  const auto lasts = [&](const char* frame, const Flag ProcessImage::*told) {
    EXPECT_FALSE(bench.image.*told);
    for (int i = 0; i < 3; ++i) {
      bench.send(frame);
      bench.tick(500);
      EXPECT_TRUE(bench.image.*told) << frame;
    }
    bench.tick(500);
    EXPECT_TRUE(bench.image.*told) << frame << ", ten seconds ago";
    bench.tick();
    EXPECT_FALSE(bench.image.*told) << frame;
  };
  lasts("205 E8 03 E8 03 E8 03", &ProcessImage::pdo_short);
  lasts("405 01", &ProcessImage::pdo_short);
  lasts("405 01 00 00", &ProcessImage::pdo_long);
  lasts("080 01 02", &ProcessImage::sync_misfits);
  bench.send("205 E8 03 E8 03 E8 03 FF FF");
  bench.tick();
  EXPECT_FALSE(bench.image.pdo_short || bench.image.pdo_long) << "refused for a value, not for its length";
  bench.answer("605 2F 19 10 00 0A 00 00 00");
  lasts("080", &ProcessImage::sync_misfits);
}

TEST(Emergency, IsNotSentForABusOffThatIsNoError) {
  Bench bench;
  bench.image.bus_off = true;
  bench.tick(3);
  EXPECT_EQ(bench.drain(), Frames{});
}

TEST(Emergency, OutlivesAFullQueueAndGoesFirst) {
  Bench bench(true);
  for (std::uint16_t code = 1; code <= 20; ++code) {  // nothing is drained: eight fit
    bench.image.error_code = code;
    bench.tick();
  }
  for (int i = 0; i < 50; ++i) bench.send("605 40 00 10 00 00 00 00 00");
  bench.send("080");
  bench.tick(100);
  EXPECT_GT(bench.node.counters().queue_overflow, 0U);
  const Frames frames = bench.drain();
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(frames[i].substr(0, 3), "085") << i;
  EXPECT_EQ(frames[8].substr(0, 3), "705");
  EXPECT_EQ(frames[9].substr(0, 3), "185");
  EXPECT_EQ(frames.back().substr(0, 3), "585");
  bench.tick();
  EXPECT_EQ(bench.drain()[0], "085 14 00 01 00 00 00 00 00")
      << "what stands now is told as soon as there is room";
}

TEST(Emergency, CanBeSwitchedOffAndIsStillInTheHistory) {
  Bench bench;
  bench.answer("605 23 14 10 00 85 00 00 80");
  bench.image.error_code = 0x5000;
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{});
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 01 00 00 00");
}

}  // namespace
}  // namespace plenum::canopen
