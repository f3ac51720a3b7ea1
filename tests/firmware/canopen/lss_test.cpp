// LSS, frame by frame, written from CiA 305. The bench's identity: vendor 11h, product 22h, revision 33h, serial 44h.
#include <gtest/gtest.h>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

constexpr const char* kConfiguration = "7E5 04 01 00 00 00 00 00 00";
constexpr const char* kWaiting = "7E5 04 00 00 00 00 00 00 00";
constexpr const char* kNodeId9 = "7E5 11 09 00 00 00 00 00 00";
constexpr const char* kInquireNodeId = "7E5 5E 00 00 00 00 00 00 00";
constexpr const char* kStore = "7E5 17 00 00 00 00 00 00 00";

TEST(Lss, IsSwitchedGlobally) {
  Bench bench;
  EXPECT_EQ(bench.answer(kInquireNodeId), "") << "not while it waits";
  EXPECT_EQ(bench.answer(kConfiguration), "");
  EXPECT_EQ(bench.answer(kInquireNodeId), "7E4 5E 05 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kWaiting), "");
  EXPECT_EQ(bench.answer(kInquireNodeId), "");
}

TEST(Lss, IsSwitchedByItsIdentity) {
  Bench bench;
  EXPECT_EQ(bench.answer("7E5 40 11 00 00 00 00 00 00"), "");
  EXPECT_EQ(bench.answer("7E5 41 22 00 00 00 00 00 00"), "");
  EXPECT_EQ(bench.answer("7E5 42 33 00 00 00 00 00 00"), "");
  EXPECT_EQ(bench.answer("7E5 43 44 00 00 00 00 00 00"), "7E4 44 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kInquireNodeId), "7E4 5E 05 00 00 00 00 00 00");
}

TEST(Lss, IsNotSwitchedByAnotherIdentityOrOutOfOrder) {
  for (const Frames& frames : {Frames{"7E5 40 11 00 00 00 00 00 00", "7E5 41 22 00 00 00 00 00 00",
                                      "7E5 42 33 00 00 00 00 00 00", "7E5 43 45 00 00 00 00 00 00"},
                               Frames{"7E5 40 11 00 00 00 00 00 00", "7E5 41 23 00 00 00 00 00 00",
                                      "7E5 42 33 00 00 00 00 00 00", "7E5 43 44 00 00 00 00 00 00"},
                               Frames{"7E5 43 44 00 00 00 00 00 00", "7E5 42 33 00 00 00 00 00 00",
                                      "7E5 41 22 00 00 00 00 00 00", "7E5 40 11 00 00 00 00 00 00"},
                               Frames{"7E5 43 44 00 00 00 00 00 00"}}) {
    Bench bench;
    for (const std::string& frame : frames) EXPECT_EQ(bench.answer(frame), "") << frame;
    EXPECT_EQ(bench.answer(kInquireNodeId), "");
  }
}

TEST(Lss, TellsItsIdentity) {
  Bench bench;
  bench.answer(kConfiguration);
  EXPECT_EQ(bench.answer("7E5 5A 00 00 00 00 00 00 00"), "7E4 5A 11 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer("7E5 5B 00 00 00 00 00 00 00"), "7E4 5B 22 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer("7E5 5C 00 00 00 00 00 00 00"), "7E4 5C 33 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer("7E5 5D 00 00 00 00 00 00 00"), "7E4 5D 44 00 00 00 00 00 00");
}

TEST(Lss, GivesANodeIdThatCountsFromTheNextReset) {
  Bench bench;
  bench.answer(kConfiguration);
  EXPECT_EQ(bench.answer("7E5 11 00 00 00 00 00 00 00"), "7E4 11 01 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer("7E5 11 80 00 00 00 00 00 00"), "7E4 11 01 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kNodeId9), "7E4 11 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kInquireNodeId), "7E4 5E 05 00 00 00 00 00 00");
  bench.answer(kWaiting);
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF");
  bench.send("000 82 05");
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"709 00"});
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "");
  EXPECT_EQ(bench.answer("609 40 00 12 02 00 00 00 00"), "589 43 00 12 02 89 05 00 00");
  EXPECT_EQ(bench.answer("609 40 14 10 00 00 00 00 00"), "589 43 14 10 00 89 00 00 00");
}

TEST(Lss, KnowsTheBitRatesOfTable0) {
  Bench bench;
  bench.answer(kConfiguration);
  for (const char* row : {"00", "01", "02", "03", "04", "06", "07", "08"})
    EXPECT_EQ(bench.answer(std::string("7E5 13 00 ") + row + " 00 00 00 00 00"),
              "7E4 13 00 00 00 00 00 00 00");
  for (const char* row : {"00 05", "00 09", "00 FF", "01 00"})
    EXPECT_EQ(bench.answer(std::string("7E5 13 ") + row + " 00 00 00 00 00"), "7E4 13 01 00 00 00 00 00 00");
}

TEST(Lss, RefusesABitRateThatTheBoardCannotRun) {
  ProcessImage image;
  FakeDesk desk;
  config::SettingsDesk settings;
  telemetry::Recorder recorder;
  Node node(Config{.node_id = 5, .bit_rates = 1U << 0 | 1U << 3}, image, desk, settings, recorder);
  node.receive(frame_from(kConfiguration));
  const auto answer = [&](const char* row) {
    for (ports::CanFrame frame; node.next_frame(frame);) continue;
    node.receive(frame_from(std::string("7E5 13 00 ") + row + " 00 00 00 00 00"));
    ports::CanFrame frame;
    return node.next_frame(frame) ? text_of(frame) : "";
  };
  for (const char* row : {"00", "03"}) EXPECT_EQ(answer(row), "7E4 13 00 00 00 00 00 00 00") << row;
  for (const char* row : {"01", "02", "04", "06", "07", "08"})
    EXPECT_EQ(answer(row), "7E4 13 01 00 00 00 00 00 00") << row;
}

TEST(Lss, StoresThroughTheParameterStoreAndAnswersWhenItIsDone) {
  Bench bench;
  bench.answer(kConfiguration);
  bench.answer(kNodeId9);
  bench.answer("7E5 13 00 02 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kStore), "");
  StoreOrder& order = bench.node.order();
  EXPECT_EQ(order.what, StoreOrder::What::lss);
  EXPECT_EQ(order.lss, (config::LssSettings{.node_id = 9, .bit_rate_kbit = 500}));
  bench.tick(3);
  EXPECT_EQ(bench.drain(), Frames{});
  EXPECT_EQ(bench.answer(kStore), "7E4 17 02 00 00 00 00 00 00") << "one at a time";
  order.done = true;
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"7E4 17 00 00 00 00 00 00 00"});
  EXPECT_EQ(order.what, StoreOrder::What::none);
}

TEST(Lss, SaysWhenTheStoreFailsOrDoesNotAnswer) {
  for (const bool answers : {true, false}) {
    Bench bench;
    bench.answer("605 2B 17 10 00 00 00 00 00");  // no heartbeat in between
    bench.answer(kConfiguration);
    bench.answer(kStore);
    EXPECT_EQ(bench.node.order().lss, config::LssSettings{})
        << "nothing was configured, nothing is to change";
    if (answers) {
      bench.node.order().result = Abort::cannot_store;
      bench.node.order().done = true;
      bench.tick();
    } else {
      bench.tick(499);
      EXPECT_EQ(bench.drain(), Frames{});
      bench.tick();
    }
    EXPECT_EQ(bench.drain(), Frames{"7E4 17 02 00 00 00 00 00 00"});
  }
}

TEST(Lss, AnswersWhoAsksForItsRange) {
  const Frames ask = {"7E5 46 11 00 00 00 00 00 00", "7E5 47 22 00 00 00 00 00 00",
                      "7E5 48 30 00 00 00 00 00 00", "7E5 49 33 00 00 00 00 00 00",
                      "7E5 4A 44 00 00 00 00 00 00"};
  for (const auto& [last, answer] : {std::pair{"7E5 4B 44 00 00 00 00 00 00", "7E4 4F 00 00 00 00 00 00 00"},
                                     std::pair{"7E5 4B FF FF 00 00 00 00 00", "7E4 4F 00 00 00 00 00 00 00"},
                                     std::pair{"7E5 4B 43 00 00 00 00 00 00", ""}}) {
    Bench bench;
    for (const std::string& frame : ask) EXPECT_EQ(bench.answer(frame), "") << frame;
    EXPECT_EQ(bench.answer(last), answer);
  }
  Bench bench;
  EXPECT_EQ(bench.answer("7E5 4C 00 00 00 00 00 00 00"), "") << "it has a node id";
  EXPECT_EQ(bench.answer("7E5 51 00 00 00 00 80 00 00"), "") << "likewise";
}

TEST(Lss, KeepsOutOfAnOperationalNodeAndServesAStoppedOne) {
  Bench bench(true);
  bench.answer(kConfiguration);
  EXPECT_EQ(bench.answer(kInquireNodeId), "");
  bench.send("000 02 05");
  bench.answer(kConfiguration);
  EXPECT_EQ(bench.answer(kInquireNodeId), "7E4 5E 05 00 00 00 00 00 00");
}

TEST(Lss, KeepsOutOfABoardThatIsPastInit) {
  Bench bench;
  for (std::uint16_t face = 1; face <= word::kStateMask; ++face) {  // FAULT_HOLD, 0011b, regulates without R
    bench.image.status_word = face;
    bench.answer(kConfiguration);
    EXPECT_EQ(bench.answer(kInquireNodeId), "") << face;
  }
  bench.image.status_word = word::kReady;
  bench.answer(kConfiguration);
  EXPECT_EQ(bench.answer(kInquireNodeId), "7E4 5E 05 00 00 00 00 00 00");
}

// Otherwise it would take the next board's configuration for its own, as soon as it is back in INIT.
TEST(Lss, IsSwitchedBackToWaitingInEveryState) {
  const auto regulates = [](Bench& bench) { bench.image.status_word = word::kReady | word::kActive; };
  const auto is_operational = [](Bench& bench) { bench.send("000 01 05"); };
  const auto resets = [](Bench& bench) { bench.send("000 82 05"); };
  for (const auto& [state, enter] : {std::pair<const char*, void (*)(Bench&)>{"regulating", regulates},
                                     {"operational", is_operational},
                                     {"in a reset", resets}}) {
    Bench bench;
    bench.answer(kConfiguration);
    enter(bench);
    const std::uint32_t rejected = bench.node.counters().rejected;
    EXPECT_EQ(bench.answer(kInquireNodeId), "") << state;
    EXPECT_EQ(bench.answer("7E5 04 00"), "") << state;  // too short
    EXPECT_EQ(bench.answer(kWaiting), "") << state;
    EXPECT_EQ(bench.answer(kConfiguration), "") << state;
    EXPECT_EQ(bench.node.counters().rejected, rejected) << state << ": what is not served is not judged";
    bench.image.status_word = word::kReady;
    bench.tick();
    bench.send("000 80 05");
    bench.drain();
    EXPECT_EQ(bench.answer(kInquireNodeId), "") << state;
    EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF") << state;
  }
}

TEST(Lss, WaitsAgainAfterAResetAndAfterOperational) {
  const Frames inquiry{"7E4 5E 05 00 00 00 00 00 00"};
  for (const auto& commands : {Frames{"000 82 05"}, Frames{"000 81 00"}, Frames{"000 01 05", "000 80 05"}}) {
    Bench bench;
    bench.send("7E5 04 01 00 00 00 00 00 00");
    bench.send("7E5 5E 00 00 00 00 00 00 00");
    EXPECT_EQ(bench.drain(), inquiry);
    for (const std::string& command : commands) bench.send(command);
    bench.tick();
    bench.drain();
    EXPECT_EQ(bench.answer("7E5 5E 00 00 00 00 00 00 00"), "") << commands[0];
  }
}

TEST(Lss, NewNodeIdTakesTheControlWordBack) {
  for (const auto& [id, expected] :
       {std::pair{"05", word::kHold}, std::pair{"09", std::uint16_t{0}}, std::pair{"FF", std::uint16_t{0}}}) {
    Bench bench;
    bench.answer(kConfiguration);
    bench.answer(std::string("7E5 11 ") + id + " 00 00 00 00 00 00");
    bench.image.control_word = word::kHold;
    bench.send("000 82 05");
    bench.tick();
    EXPECT_EQ(bench.image.control_word, expected) << id;
  }
}

TEST(Lss, LeavesMalformedFramesAlone) {
  Bench bench;
  for (const char* frame :
       {"7E5 04 01", "7E5 04 02 00 00 00 00 00 00", "7E4 04 01 00 00 00 00 00 00", "7E5"}) {
    EXPECT_EQ(bench.answer(frame), "") << frame;
    EXPECT_EQ(bench.answer(kInquireNodeId), "") << frame;
  }
}

/// A board that has never been given a node id.
struct Nameless : Bench {
  Nameless() : Bench() {
    answer(kConfiguration);
    answer("7E5 11 FF 00 00 00 00 00 00");
    answer(kWaiting);
    send("000 82 00");
    tick();
  }
};

TEST(LssUnconfigured, IsSilentButForLss) {
  Nameless bench;
  EXPECT_EQ(bench.node.state(), NmtState::initialising);
  bench.image.error_code = 0x5000;
  for (const char* frame :
       {"000 01 00", "000 80 00", "605 40 00 10 00 00 00 00 00", "080", "6FF 40 00 10 00 00 00 00 00"})
    EXPECT_EQ(bench.answer(frame), "") << frame;
  bench.tick(300);
  EXPECT_EQ(bench.drain(), Frames{});
  EXPECT_EQ(bench.answer("7E5 4C 00 00 00 00 00 00 00"), "7E4 50 00 00 00 00 00 00 00");
}

TEST(LssUnconfigured, BootsUpWhenTheMasterHasGivenItANodeId) {
  Nameless bench;
  bench.answer(kConfiguration);
  EXPECT_EQ(bench.answer(kInquireNodeId), "7E4 5E FF 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kNodeId9), "7E4 11 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kWaiting), "");
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"709 00"});
  EXPECT_EQ(bench.node.state(), NmtState::pre_operational);
  EXPECT_EQ(bench.answer("609 40 00 10 00 00 00 00 00"), "589 43 00 10 00 98 01 FF FF");
}

/// The master's side of fastscan, as CiA 305 describes it: 32 questions a number at most.
TEST(LssUnconfigured, IsFoundByFastscan) {
  Nameless bench;
  const std::string identified = "7E4 4F 00 00 00 00 00 00 00";
  const auto ask = [&](std::uint32_t number, unsigned bit, unsigned sub, unsigned next) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "7E5 51 %02X %02X %02X %02X %02X %02X %02X", number & 0xFFU,
                  number >> 8 & 0xFFU, number >> 16 & 0xFFU, number >> 24, bit, sub, next);
    return bench.answer(text.data()) == identified;
  };
  ASSERT_TRUE(ask(0, 0x80, 0, 0));
  std::vector<std::uint32_t> found;
  for (unsigned sub = 0; sub < 4; ++sub) {
    std::uint32_t number = 0;
    for (unsigned bit = 32; bit-- > 0;) {
      if (!ask(number, bit, sub, sub)) number |= std::uint32_t{1} << bit;
    }
    EXPECT_FALSE(ask(number ^ 1U, 0, sub, (sub + 1) % 4));
    EXPECT_TRUE(ask(number, 0, sub, (sub + 1) % 4));
    found.push_back(number);
  }
  EXPECT_EQ(found, (std::vector<std::uint32_t>{0x11, 0x22, 0x33, 0x44}));
  EXPECT_EQ(bench.answer(kInquireNodeId), "7E4 5E FF 00 00 00 00 00 00") << "it is in configuration";
}

}  // namespace
}  // namespace plenum::canopen
