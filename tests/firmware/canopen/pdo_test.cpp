#include <gtest/gtest.h>

#include <limits>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

// 1000, 2000, 3000, 4000 mbar
constexpr const char* kSetpoints = "205 E8 03 D0 07 B8 0B A0 0F";

TEST(Rpdo, LatchesSetPointsUntilTheSync) {
  Bench bench(true);
  bench.send(kSetpoints);
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 0.0F);
  EXPECT_EQ(bench.image.setpoint_count, 0U);
  bench.send("080");
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 100000.0F);
  EXPECT_EQ(bench.image.chamber[1].setpoint_Pa.value(), 200000.0F);
  EXPECT_EQ(bench.image.chamber[2].setpoint_Pa.value(), 300000.0F);
  EXPECT_EQ(bench.image.chamber[3].setpoint_Pa.value(), 400000.0F);
  EXPECT_EQ(bench.image.setpoint_count, 1U);
  bench.send("080");
  EXPECT_EQ(bench.image.setpoint_count, 1U) << "one frame counts once";
  bench.send("305 E8 03 D0 07 B8 0B A0 0F");
  bench.send("080 01");  // a SYNC with counter
  EXPECT_EQ(bench.image.chamber[7].setpoint_Pa.value(), 400000.0F);
  EXPECT_EQ(bench.image.setpoint_count, 1U) << "of two streams only one has come anew";
  bench.send(kSetpoints);
  bench.send("080");
  EXPECT_EQ(bench.image.setpoint_count, 2U);
}

TEST(Rpdo, TakesTheNewestOfTwoFramesBeforeASync) {
  Bench bench(true);
  bench.send(kSetpoints);
  bench.send("205 0A 00 0A 00 0A 00 0A 00");
  bench.send("080");
  EXPECT_EQ(bench.image.chamber[3].setpoint_Pa.value(), 1000.0F);
}

TEST(Rpdo, ForgetsAFrameThatHasWaitedASecondForItsSync) {
  Bench bench(true);
  bench.send(kSetpoints);
  bench.tick(100);
  bench.send("080");
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 100000.0F) << "1 s";
  bench.send("205 0A 00 0A 00 0A 00 0A 00");
  bench.tick(101);
  bench.send("080");
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 100000.0F)
      << "whoever sends this SYNC knows nothing of that frame";
  bench.answer("605 23 06 10 00 80 84 1E 00");  // SYNC every 2 s
  bench.send("205 0A 00 0A 00 0A 00 0A 00");
  bench.tick(400);
  bench.send("080");
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 1000.0F) << "two periods of SYNC";
}

TEST(Rpdo, AppliesTheControlWordAtOnceAndDoesNotCountItAsASetPoint) {
  Bench bench(true);
  bench.send("405 07 00");
  EXPECT_EQ(bench.image.control_word, 7);
  EXPECT_EQ(bench.image.setpoint_count, 0U);
}

TEST(Rpdo, LeavesTheWordInWhichResetRoseForTheControllerWhateverComesAfterIt) {
  Bench bench(true);
  bench.send("405 09 00");
  bench.send("405 01 00");
  EXPECT_EQ(bench.image.control_word, 1);
  EXPECT_EQ(bench.image.reset_word, 9);
  bench.send("405 0F 00");
  EXPECT_EQ(bench.image.reset_word, 15) << "the last one counts";
  bench.image.reset_word = 0;
  bench.send("405 09 00");
  EXPECT_EQ(bench.image.reset_word, 0) << "R stands, that is no edge";
  bench.answer("605 2B 40 60 00 00 00 00 00");
  bench.answer("605 2B 40 60 00 08 00 00 00");
  EXPECT_EQ(bench.image.reset_word, 8);
}

TEST(Rpdo, EveryBitOfItsParametersIsToldThatFlips) {
  Bench bench(true);
  for (const Rpdo& rpdo : bench.node.communication().rpdo) {
    auto* const bytes = reinterpret_cast<unsigned char*>(const_cast<PdoParameters*>(&rpdo.parameters()));
    for (std::size_t bit = 0; bit < 8 * sizeof rpdo.parameters(); ++bit) {
      bytes[bit / 8] ^= static_cast<unsigned char>(1U << bit % 8);
      EXPECT_FALSE(bench.node.intact()) << "bit " << bit;
      bytes[bit / 8] ^= static_cast<unsigned char>(1U << bit % 8);
    }
  }
  EXPECT_TRUE(bench.node.intact());
}

TEST(Rpdo, IsIntactWhateverIsWrittenToItAndRefusedAndAfterAReset) {
  Bench bench(true);
  for (const char* request : {
           "605 23 00 14 01 05 02 00 80",  // 1400h:1, switched off
           "605 2F 00 14 02 FE 00 00 00",  // its transmission type
           "605 2B 00 14 05 64 00 00 00",  // its event timer
           "605 2F 00 16 00 00 00 00 00",  // 1600h: emptied,
           "605 23 00 16 01 20 01 50 21",  // mapped anew: 2150h:1, 32 bits,
           "605 23 00 16 02 20 00 18 10",  // refused: 1018h:0 is not mappable
           "605 2F 00 16 00 01 00 00 00",  // and active,
           "605 23 00 14 01 05 02 00 00",  // and on
           "605 23 00 14 01 05 03 00 00",  // refused: another identifier while it is on
       }) {
    bench.send(request);
    EXPECT_TRUE(bench.node.intact()) << request;
  }
  EXPECT_EQ(bench.node.communication().rpdo[0].parameters().mapping.bytes, 4) << "the writes were taken";
  bench.send("000 82 05");
  bench.node.tick(10'000);
  EXPECT_TRUE(bench.node.intact());
}

TEST(Rpdo, IgnoresWhatIsMalformedForeignOrOutOfRange) {
  Bench bench(true);
  bench.send(kSetpoints);
  for (const char* bad : {"205 01 00 01 00 01 00 01", "205 01 00", "205", "206 01 00 01 00 01 00 01 00",
                          "205 FF FF 01 00 01 00 01 00",  // -1 mbar
                          "405 07", "505 07 00", "080 00 00"}) {
    bench.send(bad);
    EXPECT_EQ(bench.image.control_word, 0) << bad;
    EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 0.0F) << bad;
  }
  for (int kind = 0; kind < 2; ++kind) {
    ports::CanFrame frame = frame_from("405 07 00");
    (kind == 0 ? frame.extended : frame.remote) = true;
    bench.node.receive(frame);
    frame = frame_from("080");
    (kind == 0 ? frame.extended : frame.remote) = true;
    bench.node.receive(frame);
  }
  EXPECT_EQ(bench.image.control_word, 0);
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 0.0F);
  EXPECT_EQ(bench.node.counters().rejected, 6U);
  bench.send("080");
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 100000.0F)
      << "the good frame before them still stands";
}

// CiA 301, RPDO mapping: of more data than are mapped the first count. Some masters pad each frame to eight bytes.
TEST(Rpdo, TakesTheBeginningOfALongerOne) {
  Bench bench(true);
  bench.send("405 07 00 FF FF FF FF FF FF");
  EXPECT_EQ(bench.image.control_word, 7);
  EXPECT_EQ(bench.node.counters().rejected, 0U);
  EXPECT_EQ(bench.answer("605 2F 02 14 02 01 00 00 00"), "585 60 02 14 02 00 00 00 00") << "synchronous";
  bench.send("405 03 00 FF");
  EXPECT_EQ(bench.image.control_word, 7);
  bench.send("080");
  EXPECT_EQ(bench.image.control_word, 3);
}

TEST(Rpdo, IgnoresANonFiniteRealAndCountsIt) {
  Bench bench;
  bench.answer("605 23 00 14 01 05 02 00 80");
  bench.answer("605 2F 00 16 00 00 00 00 00");
  bench.answer("605 23 00 16 01 20 01 50 21");
  bench.answer("605 23 00 16 02 20 01 51 21");
  bench.answer("605 2F 00 16 00 02 00 00 00");
  bench.answer("605 23 00 14 01 05 02 00 00");
  bench.send("000 01 05");
  bench.send("205 00 50 C3 47 00 00 C0 7F");  // 100000 Pa, NaN
  bench.send("205 00 50 C3 47 00 00 80 FF");  // 100000 Pa, -inf
  bench.send("080");
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 0.0F) << "a PDO is taken whole or not at all";
  EXPECT_EQ(bench.node.counters().rejected, 2U);
  bench.send("205 00 50 C3 47 00 50 43 48");  // 100000 Pa, 200000 Pa
  bench.send("080");
  EXPECT_EQ(bench.image.chamber[0].setpoint_Pa.value(), 100000.0F);
  EXPECT_EQ(bench.image.chamber[1].setpoint_Pa.value(), 200000.0F);
}

TEST(Rpdo, AreHeardOnlyWhileOperational) {
  Bench bench;
  bench.send("405 07 00");
  bench.send(kSetpoints);
  bench.send("080");
  EXPECT_EQ(bench.image, ProcessImage{}) << "pre-operational";
  bench.send("000 01 05");
  bench.send(kSetpoints);
  bench.send("000 80 05");
  bench.send("000 01 05");
  bench.send("080");
  EXPECT_EQ(bench.image.setpoint_count, 0U) << "what was latched before is gone";
}

TEST(Tpdo, SendsActualValuesAfterEachSync) {
  Bench bench(true);
  for (std::size_t c = 0; c < 8; ++c)
    bench.image.chamber[c].actual_Pa = 100000.0F * static_cast<float>(c + 1);
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{});
  bench.send("080");
  EXPECT_EQ(bench.drain(), Frames{}) << "what is sent is sampled at the tick";
  bench.tick();
  EXPECT_EQ(bench.drain(), (Frames{"185 E8 03 D0 07 B8 0B A0 0F", "285 88 13 70 17 58 1B 40 1F"}));
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{});
}

TEST(Tpdo, SkipsSyncsAsItsTransmissionTypeSays) {
  Bench bench;
  bench.answer("605 2F 00 18 02 03 00 00 00");
  bench.answer("605 23 01 18 01 85 02 00 C0");  // TPDO2 off
  bench.send("000 01 05");
  bench.tick();
  bench.drain();
  int sent = 0;
  for (int i = 1; i <= 9; ++i) {
    bench.send("080");
    bench.tick();
    const bool now = !bench.drain().empty();
    EXPECT_EQ(now, i % 3 == 0) << "SYNC " << i;
    sent += now ? 1 : 0;
  }
  EXPECT_EQ(sent, 3);
}

TEST(Tpdo, OfTypeZeroIsSentWithASyncOnlyAfterAChange) {
  Bench bench;
  bench.answer("605 2F 00 18 02 00 00 00 00");
  bench.answer("605 23 01 18 01 85 02 00 C0");
  bench.send("000 01 05");
  bench.send("080");
  bench.tick();
  bench.drain();
  bench.send("080");
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{});
  bench.image.chamber[2].actual_Pa = 100.0F;
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{}) << "not without a SYNC";
  bench.send("080");
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"185 00 00 00 00 01 00 00 00"});
}

TEST(Tpdo, SendsTheStatusWordOnChangeAndByItsEventTimer) {
  Bench bench;
  bench.answer("605 2B 17 10 00 00 00 00 00");
  bench.send("000 01 05");
  bench.tick();
  EXPECT_EQ(bench.drain(), (Frames{"385 00 00", "485 00 00 00 00"}))
      << "once when the node becomes operational";
  bench.image.status_word = 0x0009;
  bench.tick();
  EXPECT_EQ(bench.drain(), (Frames{"385 09 00", "485 09 00 00 00"}));
  bench.image.error_code = 0x8250;  // of TPDO4 alone
  bench.tick();
  EXPECT_EQ(bench.drain(), (Frames{"085 50 82 01 00 00 00 00 00", "485 09 00 50 82"}));
  bench.tick(48);
  EXPECT_EQ(bench.drain(), Frames{});
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"385 09 00"}) << "500 ms after the last";
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"485 09 00 50 82"}) << "likewise";
}

TEST(Tpdo, PausesNoLongerThanItsEventTimerAlsoWhereThatIsNoMultipleOfTheTick) {
  Bench bench(true);
  bench.answer("605 2B 17 10 00 00 00 00 00");
  for (const auto& [bytes, ticks] :
       {std::pair{"19 00", 2}, {"1E 00", 3}, {"0F 00", 1}, {"05 00", 1}}) {  // 25, 30, 15, 5 ms
    bench.answer(std::string("605 2B 02 18 05 ") + bytes + " 00 00");
    while (bench.drain().empty()) bench.tick();
    for (int i = 0; i < 3; ++i) {
      bench.tick(ticks - 1);
      EXPECT_EQ(bench.drain(), Frames{}) << bytes;
      bench.tick();
      EXPECT_EQ(bench.drain(), Frames{"385 00 00"}) << bytes;
    }
  }
}

TEST(Tpdo, WaitsForItsInhibitTime) {
  Bench bench;
  bench.answer("605 23 03 18 01 85 04 00 C0");
  bench.answer("605 2B 17 10 00 00 00 00 00");
  bench.answer("605 23 02 18 01 85 03 00 C0");
  bench.answer("605 2B 02 18 03 2C 01 00 00");  // 300 x 100 us
  bench.answer("605 23 02 18 01 85 03 00 40");
  bench.send("000 01 05");
  bench.tick();
  bench.drain();
  bench.image.status_word = 1;
  bench.tick(2);
  EXPECT_EQ(bench.drain(), Frames{});
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"385 01 00"});
}

TEST(Tpdo, StreamsPressureCommandAndVolumeOfAChamberInOneFrame) {
  Bench bench;
  bench.answer("605 23 06 18 01 82 06 00 40");  // TPDO7 to 682h, as mapped by default
  bench.send("000 01 05");
  bench.tick();
  bench.drain();
  bench.image.chamber[2].actual_Pa = 100000.0F;
  bench.image.chamber[2].command_V = 5.0F;
  bench.image.chamber[2].volume_m3 = 1.0e-4F;
  bench.send("080");
  bench.tick();
  const Frames frames = bench.drain();
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[2], "682 00 50 C3 47 00 80 E8 03");  // 32767.5 rounds up; 1000 x 1e-7 m3
}

TEST(Tpdo, DoesNotLeaveOnceTheNodeIsStopped) {
  Bench bench(true);
  bench.send("080");
  bench.tick();
  bench.send("000 02 05");
  EXPECT_EQ(bench.drain(), Frames{});
}

TEST(Tpdo, GivesTheNewestValueWhenTheBusIsSlow) {
  Bench bench(true);
  bench.send("080");
  bench.tick();
  bench.image.chamber[0].actual_Pa = 500.0F;
  bench.send("080");
  bench.tick();
  EXPECT_EQ(bench.drain(), (Frames{"185 05 00 00 00 00 00 00 00", "285 00 00 00 00 00 00 00 00"}));
  EXPECT_EQ(bench.node.counters().pdo_overwritten, 2U);
}

// ---- the set-point watchdog ----

struct Watched : Bench {
  Watched() : Bench(true) {
    send("405 07 00");
    feed();
    tick();
    drain();
  }
  void feed() {
    send(kSetpoints);
    send("080");
  }
};

TEST(SetpointWatchdog, IsFedByTheStream) {
  Watched bench;
  for (int i = 0; i < 100; ++i) {
    bench.feed();
    bench.tick(5);
    EXPECT_FALSE(bench.image.setpoint_lost) << "after " << i;
  }
}

TEST(SetpointWatchdog, SeesALostStreamAfterItsEventTimerAndLeavesItsReportToTheController) {
  Watched bench;
  bench.tick(9);
  EXPECT_FALSE(bench.image.setpoint_lost) << "100 ms";
  bench.tick();
  EXPECT_TRUE(bench.image.setpoint_lost);
  EXPECT_EQ(bench.drain(), Frames{}) << "the emergency comes with the fault's status word and outputs";
  bench.image.error_code = 0x8250;
  bench.image.error_register = 0x11;
  bench.tick();
  EXPECT_EQ(bench.drain(), (Frames{"085 50 82 11 00 00 00 00 00", "485 00 00 50 82"}));
  bench.feed();
  bench.tick();
  EXPECT_FALSE(bench.image.setpoint_lost);
}

TEST(SetpointWatchdog, SeesAStreamEndThoughSetPointFramesComeWithoutSync) {
  Watched bench;
  for (int i = 0; i < 10; ++i) {
    bench.send(kSetpoints);
    bench.tick();
  }
  EXPECT_TRUE(bench.image.setpoint_lost);
}

TEST(SetpointWatchdog, IsNotFooledByStoppingTheNode) {
  Watched bench;
  bench.send("000 02 05");
  bench.tick(10);
  EXPECT_TRUE(bench.image.setpoint_lost);
  bench.image.error_code = 0x8250;
  bench.image.error_register = 0x11;
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{}) << "a stopped node may not send an emergency";
  bench.send("000 80 05");
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"085 50 82 11 00 00 00 00 00"}) << "but has not forgotten it";
}

TEST(SetpointWatchdog, TakesAResetOfTheCommunicationForTheStreamsEnd) {
  Watched bench;
  bench.send("000 82 05");
  bench.tick();
  EXPECT_TRUE(bench.image.setpoint_lost) << "the machine goes on, and nothing watches its master any more";
  bench.tick();
  EXPECT_FALSE(bench.image.setpoint_lost) << "told once: the controller keeps it";
  Watched at_rest;
  at_rest.send("405 01 00");
  at_rest.send("000 82 05");
  at_rest.tick();
  EXPECT_FALSE(at_rest.image.setpoint_lost);
}

TEST(SetpointWatchdog, IsNotEndedByWhatIsWrittenToTheParametersOfAStream) {
  const std::string type_as_it_is = "605 2F 00 14 02 01 00 00 00";
  const std::string switched_off = "605 23 00 14 01 05 02 00 80";
  const std::string deadline = "605 2B 00 14 05 32 00 00 00";  // 50 ms
  for (const std::string& written : {type_as_it_is, switched_off, deadline}) {
    Watched bench;
    ASSERT_TRUE(bench.answer(written).starts_with("585 60")) << written;
    bench.tick(9);
    const std::uint32_t vouched = bench.image.setpoint_count;
    bench.send("305 00 00 00 00 00 00 00 00");  // the other stream goes on
    bench.send("080");
    bench.tick();
    bench.tick();
    EXPECT_TRUE(bench.image.setpoint_lost) << written;
    EXPECT_LE(bench.image.setpoint_count, vouched + 1) << written;
  }
}

TEST(SetpointWatchdog, IsNotFedByAnotherStreamOnceAStreamIsMappedToNothing) {
  Watched bench;
  const std::string other = "305 00 00 00 00 00 00 00 00";
  bench.send(other);
  bench.feed();
  bench.tick();
  bench.answer("605 2B 00 14 05 00 00 00 00");  // no deadline of its own: what both feed is 2419h:2
  bench.answer("605 2B 01 14 05 00 00 00 00");
  bench.answer("605 23 00 14 01 05 02 00 80");
  bench.answer("605 2F 00 16 00 00 00 00 00");
  const std::uint32_t before = bench.image.setpoint_count;
  for (int i = 0; i < 20; ++i) {
    bench.send(other);
    bench.send("080");
    bench.tick();
  }
  EXPECT_LE(bench.image.setpoint_count, before + 1);
}

TEST(SetpointWatchdog, IsTheEventTimerOfEveryRpdo) {
  Bench bench;
  bench.answer("605 2B 02 14 05 64 00 00 00");  // RPDO3, the control word: 100 ms
  bench.send("000 01 05");
  bench.tick();
  bench.send("405 07 00");
  bench.tick(10);
  EXPECT_FALSE(bench.image.setpoint_lost);
  EXPECT_EQ(bench.image.setpoint_count, 0U) << "a control word is no set point";
  bench.tick();
  EXPECT_TRUE(bench.image.setpoint_lost);
  bench.send("405 07 00");
  bench.tick();
  EXPECT_FALSE(bench.image.setpoint_lost);
}

TEST(SetpointWatchdog, IsFedBySetPointsWrittenBySdoWhereNoneComesByPdo) {
  Bench bench;
  bench.answer("605 2B 40 60 00 07 00 00 00");  // ACTIVE
  bench.tick();
  bench.answer("605 2B 80 63 01 E8 03 00 00");
  EXPECT_EQ(bench.image.setpoint_count, 1U);
  bench.image.setpoints_came = 0;               // as the controller does in each tick
  bench.answer("605 23 51 21 01 00 50 C3 47");  // 2151h:1, 100 kPa
  EXPECT_EQ(bench.image.setpoint_count, 2U);
  bench.image.setpoints_came = 0;
  bench.answer("605 40 80 63 01 00 00 00 00");
  bench.answer("605 2B 80 63 01 18 FC 00 00");  // below its range
  bench.answer("605 2B 94 63 01 E8 03 00 00");  // the set point of HOLD
  EXPECT_EQ(bench.image.setpoint_count, 2U) << "reading, a refused value and another object are no news";
}

TEST(SetpointWatchdog, IsNotFedBySdoWhileAStreamOfPdosIsDue) {
  Watched bench;
  const std::uint32_t streamed = bench.image.setpoint_count;
  bench.image.setpoints_came = 0;
  bench.answer("605 2B 80 63 01 E8 03 00 00");
  EXPECT_EQ(bench.image.setpoint_count, streamed) << "whoever else writes does not vouch for its master";
}

TEST(SetpointWatchdog, RestsInExcitationButForTheControlWords) {
  Bench bench;
  bench.answer("605 2F 43 60 00 FF 00 00 00");
  bench.answer("605 2B 02 14 05 C8 00 00 00");  // RPDO3: 200 ms
  bench.send("000 01 05");
  bench.tick();
  bench.send("405 07 00");
  bench.send(kSetpoints);
  bench.send("080");
  bench.tick(20);
  EXPECT_FALSE(bench.image.setpoint_lost) << "the set points' 100 ms are over, but none is needed";
  bench.tick();
  EXPECT_TRUE(bench.image.setpoint_lost) << "the control word's 200 ms are not";
}

TEST(SetpointWatchdog, RestsUnlessActiveIsAskedFor) {
  Watched bench;
  bench.send("405 03 00");
  bench.tick(100);
  EXPECT_FALSE(bench.image.setpoint_lost);
  bench.send("405 07 00");
  bench.tick(100);
  EXPECT_FALSE(bench.image.setpoint_lost) << "the old stream ended long ago, a new one has not begun";
}

}  // namespace
}  // namespace plenum::canopen
