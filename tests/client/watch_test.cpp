// What a bystander makes of frames, written by hand from the table of default PDOs in firmware/canopen/README.md.
#include "host-sim/client/watch.hpp"

#include <gtest/gtest.h>

#include "tests/client/board_on_bus.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::host::client {
namespace {

TEST(Watch, ReadsWhatTheBoardAndItsMasterSendByDefault) {
  Watch watch(5);
  const auto take = [&](const char* text) { watch.take(1.5, canopen::frame_from(text)); };
  take("185 E8 03 D0 07 B8 0B 00 80");  // 1000, 2000, 3000 mbar, none
  take("285 01 00 02 00 03 00 04 00");
  take("205 F4 01 E8 03 DC 05 D0 07");
  take("305 0A 00 14 00 1E 00 28 00");
  take("385 0F 00");
  take("705 05");
  take("085 50 82 11 03 00 00 00 00");
  const BoardView view = watch.view(1.5);
  EXPECT_EQ(view.chamber[0].actual_Pa, 100'000.0);
  EXPECT_EQ(view.chamber[2].actual_Pa, 300'000.0);
  EXPECT_EQ(view.chamber[3].actual_Pa, std::nullopt) << "the board measured no number";
  EXPECT_EQ(view.chamber[7].actual_Pa, 400.0);
  EXPECT_EQ(view.chamber[0].setpoint_Pa, 50'000.0);
  EXPECT_EQ(view.chamber[7].setpoint_Pa, 4'000.0);
  EXPECT_EQ(view.chamber[0].command_V, std::nullopt) << "no default PDO carries it";
  EXPECT_EQ(view.status_word, 0x0F);
  EXPECT_EQ(view.nmt, canopen::NmtState::operational);
  EXPECT_EQ(view.error_code, 0x8250);
  EXPECT_EQ(view.fault_chamber, 3U);
  EXPECT_EQ(view.frames, 7U);
  EXPECT_EQ(view.silent_s, std::nullopt);
}

TEST(Watch, TellsNoStateOfANodeThatHasJustBooted) {
  Watch watch(5);
  watch.take(10.0, canopen::frame_from("705 05"));
  watch.take(10.5, canopen::frame_from("705 00"));
  EXPECT_EQ(watch.view(10.6).nmt, std::nullopt) << "no heartbeat has come since";
}

TEST(Watch, DoesNotShowWhatIsOldAsIfItWereOfNow) {
  Watch watch(5);
  EXPECT_EQ(watch.view(100.0).silent_s, std::nullopt) << "nothing was heard that could have ended";
  watch.take(10.0, canopen::frame_from("705 05"));
  watch.take(10.5, canopen::frame_from("385 0F 00"));
  watch.take(10.5, canopen::frame_from("085 50 82 11 03 00 00 00 00"));
  watch.take(10.5, canopen::frame_from("185 E8 03 D0 07 B8 0B 00 80"));
  watch.take(12.4, canopen::frame_from("205 F4 01 E8 03 DC 05 D0 07"));  // its master's: not a sign of life
  const BoardView young = watch.view(12.4);
  EXPECT_EQ(young.nmt, std::nullopt) << "the heartbeat is 2.4 s old";
  EXPECT_EQ(young.status_word, 0x0F);
  EXPECT_EQ(young.chamber[0].actual_Pa, 100'000.0);
  EXPECT_EQ(young.silent_s, std::nullopt);
  const BoardView old = watch.view(12.6);
  EXPECT_EQ(old.status_word, std::nullopt);
  EXPECT_EQ(old.chamber[0].actual_Pa, std::nullopt);
  EXPECT_EQ(old.chamber[0].setpoint_Pa, 50'000.0);
  EXPECT_NEAR(old.silent_s.value_or(0.0), 2.1, 1e-9);
  EXPECT_EQ(old.error_code, 0x8250) << "a fault stands until an emergency says that it is gone";
  watch.take(13.0, canopen::frame_from("705 05"));
  EXPECT_EQ(watch.view(13.0).silent_s, std::nullopt);
}

TEST(Watch, KnowsOfNoFaultOnlyWhenItHeardSo) {
  Watch watch(5);
  watch.take(0.0, canopen::frame_from("705 7F"));
  EXPECT_EQ(watch.view(0.0).error_code, std::nullopt);
  watch.take(0.0, canopen::frame_from("085 00 00 00 00 00 00 00 00"));
  EXPECT_EQ(watch.view(0.0).error_code, 0);
}

TEST(Watch, PassesOverFramesOfOthersAndOfAnotherForm) {
  Watch watch(5);
  for (const char* text : {"186 E8 03 D0 07 B8 0B A0 0F", "185 E8 03", "385 0F", "705",
                           "585 43 00 10 00 00 00 00 00", "080", "205 F4 01 E8 03"}) {
    watch.take(0.0, canopen::frame_from(text));
  }
  CanFrame extended = canopen::frame_from("185 E8 03 D0 07 B8 0B A0 0F");
  extended.extended = true;
  watch.take(0.0, extended);
  EXPECT_EQ(watch.frames(), 0U);
}

TEST(Watch, ShowsCommandAndVolumeOfAStream) {
  BoardOnBus world;
  Session session(world, 5);
  Watch watch(5);
  session.subscribe([&](const Arrival& arrival) { watch.take(arrival.time_s, arrival.frame); });
  watch.follow(session.configure_stream({.largest_volume_m3 = 6.5535e-3}));
  session.nmt(canopen::NmtCommand::start);
  world.each_tick = [&] {
    world.image.chamber[6].actual_Pa = 123456.0F;
    world.image.chamber[6].command_V = 10.0F;
    world.image.chamber[6].volume_m3 = 1.0e-3F;
  };
  session.send_sync();
  session.listen(0.03);
  EXPECT_EQ(watch.view(session.link().now_s()).chamber[6].actual_Pa, 123456.0);
  EXPECT_EQ(watch.view(session.link().now_s()).chamber[6].command_V, 10.0);
  EXPECT_NEAR(watch.view(session.link().now_s()).chamber[6].volume_m3.value_or(0.0), 1.0e-3, 0.5e-7);
}

}  // namespace
}  // namespace plenum::host::client
