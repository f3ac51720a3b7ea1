// Emergency messages and the history 1003h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

using safety::Fault;
using safety::FaultSet;
using safety::only;
using ::testing::Contains;
using ::testing::Each;

constexpr std::size_t kBoard = 0;

/// As the controller has it.
void show(ProcessImage& image) {
  safety::ChamberFaults chambers{};
  std::copy(image.standing_faults.begin() + 1, image.standing_faults.end(), chambers.begin());
  const safety::FaultReport report =
      safety::FaultRegister{}.step(chambers, image.standing_faults[kBoard], false);
  image.error_code = report.code;
  image.error_register = report.error_register;
  image.fault_chamber = report.chamber;
}

Frames told(Bench& bench) {
  show(bench.image);
  bench.tick();
  return bench.drain();
}

TEST(Emergency, IsSentOnceForEachChange) {
  Bench bench;
  bench.image.error_code = 0x8302;
  bench.image.error_register = 0x20;
  bench.image.fault_chamber = 3;
  bench.tick(3);
  EXPECT_EQ(bench.drain(), Frames{"085 02 83 21 03 00 00 00 00"});
  bench.image.error_code = 0x3412;
  bench.image.fault_chamber = 0;
  bench.tick(3);
  EXPECT_EQ(bench.drain(), Frames{"085 12 34 21 00 00 00 00 00"});
  bench.image.error_code = 0;
  bench.image.error_register = 0;
  bench.tick(3);
  EXPECT_EQ(bench.drain(), Frames{"085 00 00 00 00 00 00 00 00"});
}

TEST(Emergency, OfALostHeartbeatNamesTheNodeAndTellsOfEachOther) {
  Bench bench;
  bench.answer("605 23 16 10 01 64 00 0A 00");  // nodes 10 and 11, 100 ms
  bench.answer("605 23 16 10 02 64 00 0B 00");
  for (const char* beat : {"70A 05", "70B 05"}) bench.send(beat);
  bench.tick(8);
  bench.send("70A 05");
  bench.tick(3);
  bench.drain();
  bench.image.standing_faults[kBoard] = only(Fault::heartbeat_lost);
  EXPECT_EQ(told(bench), Frames{"085 30 81 11 00 0B 00 00 00"});
  EXPECT_EQ(told(bench), Frames{}) << "once";
  bench.tick(8);
  EXPECT_EQ(told(bench), Frames{"085 30 81 11 00 0A 00 00 00"}) << "the other one";
  bench.send("70A 05");
  bench.tick(20);
  EXPECT_EQ(told(bench), Frames{}) << "a node that comes and goes is named once while the fault stands";
}

TEST(Emergency, StandsInRegisterCodeAndHistoryAtTheSameMoment) {
  Bench bench;
  for (const std::uint16_t code : {std::uint16_t{0x8302}, std::uint16_t{0x3412}}) {
    bench.image.error_code = code;
    bench.image.fault_chamber = 1;
    bench.tick();
  }
  bench.drain();
  EXPECT_EQ(bench.answer("605 40 01 10 00 00 00 00 00"), "585 4F 01 10 00 01 00 00 00");
  EXPECT_EQ(bench.answer("605 40 4E 60 00 00 00 00 00"), "585 4B 4E 60 00 12 34 00 00");
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 02 00 00 00");
  EXPECT_EQ(bench.answer("605 40 03 10 01 00 00 00 00"), "585 43 03 10 01 12 34 01 00") << "newest first";
  EXPECT_EQ(bench.answer("605 40 03 10 02 00 00 00 00"), "585 43 03 10 02 02 83 01 00");
  EXPECT_EQ(bench.answer("605 2F 03 10 00 00 00 00 00"), "585 60 03 10 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 00 00 00 00");
}

TEST(Emergency, IsToldOnceMoreAfterTheBootUpMessageAndStandsOnceInTheHistory) {
  Bench bench;
  bench.image.error_code = 0x8250;
  bench.image.error_register = 0x11;
  bench.tick();
  bench.drain();
  for (const char* reset : {"000 82 05", "000 81 05"}) {
    bench.send(reset);
    bench.tick(2);
    EXPECT_EQ(bench.drain(), (Frames{"705 00", "085 50 82 11 00 00 00 00 00"})) << reset;
    EXPECT_EQ(bench.answer("605 40 01 10 00 00 00 00 00"), "585 4F 01 10 00 11 00 00 00") << reset;
    EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 01 00 00 00") << reset;
    EXPECT_EQ(bench.answer("605 40 03 10 01 00 00 00 00"), "585 43 03 10 01 50 82 00 00") << reset;
  }
}

TEST(Emergency, HistoryKeepsTheLastThirtyTwo) {
  Bench bench;
  for (std::uint16_t code = 1; code <= 34; ++code) {
    bench.image.error_code = code;
    bench.tick();
    bench.drain();
  }
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 20 00 00 00");
  EXPECT_EQ(bench.answer("605 40 03 10 20 00 00 00 00"), "585 43 03 10 20 03 00 00 00");
}

TEST(Emergency, IsKeptBackWhileStoppedAndNotLost) {
  Bench bench;
  bench.send("000 02 05");
  bench.image.error_code = 0x5000;
  bench.tick(5);
  EXPECT_EQ(bench.drain(), Frames{});
  bench.send("000 01 05");
  bench.tick();
  EXPECT_EQ(bench.drain()[0], "085 00 50 01 00 00 00 00 00");
}

TEST(Emergency, IsSentOnceForEachBusOffAndStandsOnceInTheHistory) {
  Bench bench;
  const Frames told{"085 40 81 11 00 00 00 00 00"};
  bench.image.error_register = 0x10;
  for (int i = 0; i < 3; ++i) {
    bench.image.bus_off = true;
    bench.image.error_code = 0x8140;
    bench.tick(3);
    EXPECT_EQ(bench.drain(), told) << "bus-off " << i;
    bench.image.bus_off = false;
    bench.tick(3);
    EXPECT_EQ(bench.drain(), Frames{}) << "back on the bus " << i;
  }
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 01 00 00 00");
}

TEST(Emergency, TellsOfALessUrgentFaultAndThenOfTheMostUrgentAgain) {
  Bench bench;
  bench.image.standing_faults[3] = only(Fault::over_pressure);
  EXPECT_EQ(told(bench), Frames{"085 02 83 21 03 00 00 00 00"});
  bench.image.standing_faults[kBoard] = only(Fault::heartbeat_lost);
  EXPECT_EQ(told(bench), (Frames{"085 30 81 31 00 00 00 00 00", "085 02 83 31 03 00 00 00 00"}));
  bench.image.standing_faults[7] = only(Fault::over_pressure);
  EXPECT_EQ(told(bench), (Frames{"085 02 83 31 07 00 00 00 00", "085 02 83 31 03 00 00 00 00"}));
  EXPECT_EQ(told(bench), Frames{}) << "each once";
  // all that stands, and each once in the history
  EXPECT_EQ(bench.answer("605 40 31 28 03 00 00 00 00"), "585 43 31 28 03 04 00 00 00");
  EXPECT_EQ(bench.answer("605 40 31 28 09 00 00 00 00"), "585 43 31 28 09 00 00 01 00");
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 03 00 00 00");
  EXPECT_EQ(bench.answer("605 40 03 10 01 00 00 00 00"), "585 43 03 10 01 02 83 07 00");
  EXPECT_EQ(bench.answer("605 40 03 10 02 00 00 00 00"), "585 43 03 10 02 30 81 00 00");
  EXPECT_EQ(bench.answer("605 40 03 10 03 00 00 00 00"), "585 43 03 10 03 02 83 03 00");
}

TEST(Emergency, OfWhatIsLeftWhenTheMostUrgentGoesIsNoNewEntryOfTheHistory) {
  Bench bench;
  bench.image.standing_faults[kBoard] = only(Fault::supply_low) | only(Fault::emergency_stop);
  EXPECT_EQ(told(bench), (Frames{"085 00 90 05 00 00 00 00 00", "085 12 34 05 00 00 00 00 00",
                                 "085 00 90 05 00 00 00 00 00"}));
  bench.image.standing_faults[kBoard] = only(Fault::supply_low);
  EXPECT_EQ(told(bench), Frames{"085 12 34 05 00 00 00 00 00"});
  bench.image.standing_faults[kBoard] = 0;
  EXPECT_EQ(told(bench), Frames{"085 00 00 00 00 00 00 00 00"});
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 02 00 00 00");
  bench.image.standing_faults[kBoard] = only(Fault::supply_low);
  EXPECT_EQ(told(bench), Frames{"085 12 34 05 00 00 00 00 00"});
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 03 00 00 00")
      << "it has come again";
}

// 8 chambers of 4 faults each, where the ring holds 8 messages.
TEST(Emergency, TellsOfManyThatRiseInOneTickInSeveralTheMostUrgentFirstAndLast) {
  Bench bench;
  constexpr std::array kFaults{Fault::pressure_stale, Fault::position_stale, Fault::no_model,
                               Fault::model_residual};
  for (std::size_t c = 0; c < config::kChambers; ++c)
    for (const Fault fault : kFaults) bench.image.standing_faults[c + 1] |= only(fault);
  Frames frames;
  int ticks = 0;
  for (Frames now = told(bench); !now.empty(); now = told(bench), ++ticks) {
    ASSERT_LT(ticks, 10);
    EXPECT_EQ(now.front(), "085 03 FF A1 01 00 00 00 00");
    frames.insert(frames.end(), now.begin(), now.end());
  }
  EXPECT_EQ(frames.back(), "085 03 FF A1 01 00 00 00 00");
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    for (const Fault fault : kFaults) {
      ports::CanFrame frame{.id = 0x85, .length = 8};
      store_le(safety::spec(fault).code, std::span(frame.data).first<2>());
      frame.data[2] = 0xA1;
      frame.data[3] = static_cast<std::uint8_t>(c + 1);
      EXPECT_THAT(frames, Contains(text_of(frame)));
    }
  }
}

TEST(Emergency, OfAFaultThatFlickersUnderAMoreUrgentOneIsSentOnce) {
  Bench bench;
  bench.image.standing_faults[kBoard] = only(Fault::bus_off);
  told(bench);
  for (int i = 0; i < 10; ++i) {
    bench.image.standing_faults[kBoard] = only(Fault::bus_off) | only(Fault::can_overrun);
    const Frames now = told(bench);
    EXPECT_EQ(now.size(), i == 0 ? 2U : 0U);
    bench.image.standing_faults[kBoard] = only(Fault::bus_off);
    EXPECT_EQ(told(bench), Frames{});
  }
  EXPECT_EQ(bench.answer("605 40 03 10 00 00 00 00 00"), "585 4F 03 10 00 02 00 00 00");
  bench.image.standing_faults[kBoard] = 0;
  told(bench);
  bench.image.standing_faults[kBoard] = only(Fault::can_overrun);
  EXPECT_EQ(told(bench).size(), 1U) << "by itself, it is told";
}

TEST(Emergency, OfWhatRisesTogetherTheMostUrgentIsTheNewestEntryOfTheHistory) {
  Bench bench;
  bench.image.standing_faults[kBoard] = only(Fault::emergency_stop);
  for (std::size_t c = 0; c < config::kChambers; ++c)
    bench.image.standing_faults[c + 1] = only(Fault::pressure_stale);
  told(bench);
  EXPECT_EQ(bench.answer("605 40 03 10 01 00 00 00 00"), "585 43 03 10 01 00 90 00 00");
}

TEST(Emergency, TellsOfTwoFaultsOfOneCodeEach) {
  Bench bench;
  bench.image.standing_faults[kBoard] = only(Fault::stored_set_lost);
  told(bench);
  bench.image.standing_faults[kBoard] |= only(Fault::store_failing);
  EXPECT_EQ(told(bench).size(), 2U);
}

TEST(Emergency, IsOfNoFaultWhereABitHasFlippedBeyondTheLast) {
  Bench bench;
  bench.image.standing_faults[4] = FaultSet{1} << 31U;
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{});
}

TEST(Emergency, OfALessUrgentFaultThatHasGoneBeforeItCouldBeToldIsNotSent) {
  Bench bench;
  bench.image.standing_faults[1] = only(Fault::over_pressure);
  told(bench);
  bench.send("000 02 05");
  bench.image.standing_faults[2] = only(Fault::model_drift);
  EXPECT_EQ(told(bench), Frames{}) << "stopped";
  bench.image.standing_faults[2] = 0;
  bench.send("000 01 05");
  const Frames later = told(bench);
  EXPECT_THAT(later, Each(::testing::Not(::testing::HasSubstr("085 0B FF"))));
}

}  // namespace
}  // namespace plenum::canopen
