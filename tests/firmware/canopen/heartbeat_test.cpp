// Heartbeats consumed (1016h), what becomes of the state when one is lost (1029h), and SYNCs that are counted (1019h).
#include <gtest/gtest.h>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

constexpr const char* kWatchNode2 = "605 23 16 10 01 64 00 02 00";  // node 2, 100 ms

struct Watching : Bench {
  explicit Watching(bool operational = false) : Bench(operational) { answer(kWatchNode2); }
};

TEST(HeartbeatConsumer, BeginsWithTheFirstHeartbeat) {
  Watching bench;
  bench.tick(100);
  EXPECT_FALSE(bench.image.heartbeat_lost) << "it has never been heard";
  bench.send("702 05");
  bench.tick(10);
  EXPECT_FALSE(bench.image.heartbeat_lost) << "100 ms";
  bench.tick();
  EXPECT_TRUE(bench.image.heartbeat_lost);
}

TEST(HeartbeatConsumer, IsFedByEveryHeartbeat) {
  Watching bench;
  for (const char* state : {"702 05", "702 7F", "702 04", "702 05"}) {
    bench.send(state);
    bench.tick(10);
    EXPECT_FALSE(bench.image.heartbeat_lost) << state;
  }
  bench.tick();
  EXPECT_TRUE(bench.image.heartbeat_lost);
  bench.send("702 05");
  bench.tick();
  EXPECT_FALSE(bench.image.heartbeat_lost) << "it is back";
}

TEST(HeartbeatConsumer, IsNotFedByAnythingElse) {
  Watching bench;
  bench.send("702 05");
  const std::uint32_t rejected = bench.node.counters().rejected;
  bench.tick(10);
  for (const char* frame : {"703 05", "702 00", "702 05 00", "702", "702 85", "702 01"}) bench.send(frame);
  bench.tick();
  EXPECT_TRUE(bench.image.heartbeat_lost);
  EXPECT_EQ(bench.node.counters().rejected - rejected, 4U)
      << "all but another node's and the boot-up message";
}

TEST(HeartbeatConsumer, DoesNotBeginWithABootUpMessage) {
  Watching bench;
  bench.send("702 00");
  bench.tick(100);
  EXPECT_FALSE(bench.image.heartbeat_lost);
}

TEST(HeartbeatConsumer, ListensInEveryState) {
  Watching bench;
  bench.send("000 02 05");
  bench.send("702 05");
  bench.tick(11);
  EXPECT_TRUE(bench.image.heartbeat_lost);
}

TEST(HeartbeatConsumer, WatchesEightNodesApart) {
  Bench bench;
  for (int n = 0; n < 8; ++n) {
    std::string request = "605 23 16 10 01 64 00 11 00";  // nodes 11h..18h
    request[14] = static_cast<char>('1' + n);
    request[23] = static_cast<char>('1' + n);
    EXPECT_EQ(bench.answer(request).substr(0, 6), "585 60") << request;
  }
  for (const char* beat : {"711 05", "718 05"}) bench.send(beat);
  bench.tick(8);
  bench.send("711 05");
  bench.tick(3);
  EXPECT_TRUE(bench.image.heartbeat_lost) << "node 18h";
  bench.send("718 05");
  bench.tick();
  EXPECT_FALSE(bench.image.heartbeat_lost);
}

TEST(HeartbeatConsumer, EndsWithItsEntry) {
  Watching bench;
  bench.send("702 05");
  bench.tick(20);
  EXPECT_TRUE(bench.image.heartbeat_lost);
  EXPECT_EQ(bench.answer("605 23 16 10 01 00 00 02 00"), "585 60 16 10 01 00 00 00 00");
  bench.tick();
  EXPECT_FALSE(bench.image.heartbeat_lost);
}

TEST(HeartbeatConsumer, TakesAResetOfTheCommunicationForItsEndWhileTheMachineRegulates) {
  Watching bench(true);
  bench.send("702 05");
  bench.send("405 03 00");  // HOLD
  bench.send("000 82 05");
  bench.tick();
  EXPECT_TRUE(bench.image.heartbeat_lost)
      << "the machine goes on, and nobody listens for its master any more";
  bench.tick();
  EXPECT_FALSE(bench.image.heartbeat_lost) << "told once: the controller keeps it";
  Watching at_rest(true);
  at_rest.send("702 05");
  at_rest.send("405 01 00");
  at_rest.send("000 82 05");
  at_rest.tick();
  EXPECT_FALSE(at_rest.image.heartbeat_lost);
  Watching unheard(true);
  unheard.send("405 03 00");
  unheard.send("000 82 05");
  unheard.tick();
  EXPECT_FALSE(unheard.image.heartbeat_lost) << "it was not watched yet";
}

TEST(HeartbeatConsumer, RefusesWhatIsNoEntry) {
  Watching bench;
  EXPECT_EQ(bench.answer("605 40 16 10 01 00 00 00 00"), "585 43 16 10 01 64 00 02 00");
  EXPECT_EQ(bench.answer("605 23 16 10 02 C8 00 02 00"), "585 80 16 10 02 43 00 04 06") << "node 2 twice";
  EXPECT_EQ(bench.answer("605 23 16 10 02 00 00 02 00"), "585 60 16 10 02 00 00 00 00") << "unused";
  EXPECT_EQ(bench.answer("605 23 16 10 01 C8 00 02 00"), "585 60 16 10 01 00 00 00 00") << "its own entry";
  EXPECT_EQ(bench.answer("605 23 16 10 02 64 00 80 00"), "585 60 16 10 02 00 00 00 00") << "node 128: unused";
  EXPECT_EQ(bench.answer("605 40 16 10 02 00 00 00 00"), "585 43 16 10 02 64 00 80 00");
  EXPECT_EQ(bench.answer("605 23 16 10 02 64 00 03 01"), "585 80 16 10 02 30 00 09 06") << "reserved bits";
  EXPECT_EQ(bench.answer("605 40 16 10 09 00 00 00 00"), "585 80 16 10 09 11 00 09 06");
}

TEST(ErrorBehaviour, LeavesOperationalWhenAHeartbeatOrTheBusIsLost) {
  for (const bool heartbeat : {true, false}) {
    for (const auto& [request, state] : {std::pair{"605 2F 29 10 01 00 00 00 00", NmtState::pre_operational},
                                         std::pair{"605 2F 29 10 01 01 00 00 00", NmtState::operational},
                                         std::pair{"605 2F 29 10 01 02 00 00 00", NmtState::stopped}}) {
      Watching bench(true);
      EXPECT_EQ(bench.answer(request), "585 60 29 10 01 00 00 00 00");
      bench.send("702 05");
      bench.image.bus_off = !heartbeat;
      bench.tick(11);
      EXPECT_EQ(bench.node.state(), state);
      bench.send("000 01 05");
      bench.tick();
      EXPECT_EQ(bench.node.state(), NmtState::operational) << "the master may start it again";
    }
  }
}

TEST(ErrorBehaviour, OfTheDeviceLetsTheHeartbeatTellOfAnyFaultWithAReaction) {
  for (const auto& [request, state] : {std::pair{"605 2F 29 10 02 00 00 00 00", NmtState::pre_operational},
                                       std::pair{"605 2F 29 10 02 01 00 00 00", NmtState::operational},
                                       std::pair{"605 2F 29 10 02 02 00 00 00", NmtState::stopped}}) {
    Bench bench;
    EXPECT_EQ(bench.answer(request), "585 60 29 10 02 00 00 00 00");
    bench.send("000 01 05");
    bench.image.status_word = 0xF;
    bench.image.error_code = 0xFF0B;  // a warning: the board goes on
    bench.tick(2);
    EXPECT_EQ(bench.node.state(), NmtState::operational);
    bench.drain();
    bench.image.status_word = 0x1;
    bench.image.error_code = 0x8302;
    bench.tick(2);
    EXPECT_EQ(bench.node.state(), state);
    EXPECT_THAT(bench.drain(), ::testing::Contains(::testing::StartsWith("085 02 83"))) << request;
    bench.send("000 01 05");
    bench.tick(2);
    EXPECT_EQ(bench.node.state(), NmtState::operational) << "the master may start it again";
  }
}

TEST(ErrorBehaviour, KnowsThreeValues) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 29 10 01 00 00 00 00"), "585 4F 29 10 01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 2F 29 10 01 03 00 00 00"), "585 80 29 10 01 31 00 09 06");
  EXPECT_EQ(bench.answer("605 40 29 10 02 00 00 00 00"), "585 4F 29 10 02 01 00 00 00");
  EXPECT_EQ(bench.answer("605 2F 29 10 02 03 00 00 00"), "585 80 29 10 02 31 00 09 06");
}

// ---- SYNC counter ----

struct Counted : Bench {
  Counted() {
    answer("605 2F 19 10 00 0A 00 00 00");  // 1019h: 1..10
    answer("605 23 00 18 01 85 01 00 C0");
    answer("605 2F 00 18 02 03 00 00 00");  // TPDO1: every third SYNC
    EXPECT_EQ(answer("605 2F 00 18 06 04 00 00 00"),
              "585 60 00 18 06 00 00 00 00");  // the fourth is the first
    answer("605 23 00 18 01 85 01 00 40");
    send("000 01 05");
    tick();
    drain();
  }
  bool sends_tpdo1_after(const std::string& sync) {
    send(sync);
    tick();
    const Frames frames = drain();
    return std::any_of(frames.begin(), frames.end(),
                       [](const std::string& frame) { return frame.substr(0, 3) == "185"; });
  }
};

TEST(SyncCounter, StartsATpdoAtItsSyncStartValue) {
  Counted bench;
  const Frames syncs = {"080 02", "080 03", "080 04", "080 05", "080 06", "080 07", "080 08", "080 09"};
  std::string sent;
  for (const std::string& sync : syncs) sent += bench.sends_tpdo1_after(sync) ? '1' : '0';
  EXPECT_EQ(sent, "00001001") << "with the third and the sixth SYNC from number 4 on";
}

TEST(SyncCounter, RefusesSyncsThatDoNotCount) {
  Counted bench;
  const std::uint32_t rejected = bench.node.counters().rejected;
  const std::uint32_t taken = bench.image.sync_count;
  for (const char* sync : {"080", "080 00", "080 0B", "080 01 00"}) bench.send(sync);
  EXPECT_EQ(bench.node.counters().rejected - rejected, 4U);
  EXPECT_EQ(bench.image.sync_count, taken);
}

TEST(SyncCounter, HasTheLimitsOfCia301) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 2F 19 10 00 01 00 00 00"), "585 80 19 10 00 30 00 09 06");
  EXPECT_EQ(bench.answer("605 2F 19 10 00 F1 00 00 00"), "585 80 19 10 00 31 00 09 06");
  EXPECT_EQ(bench.answer("605 2F 19 10 00 F0 00 00 00"), "585 60 19 10 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 23 06 10 00 10 27 00 00"), "585 60 06 10 00 00 00 00 00") << "10 ms";
  EXPECT_EQ(bench.answer("605 2F 19 10 00 00 00 00 00"), "585 80 19 10 00 22 00 00 08")
      << "while 1006h is not 0";
  EXPECT_EQ(bench.answer("605 2F 00 18 06 01 00 00 00"), "585 80 00 18 06 22 00 00 08") << "of a living PDO";
}

TEST(ControlMode, StandsWhileActive) {
  Bench bench;
  bench.image.status_word = 0x000F;
  EXPECT_EQ(bench.answer("605 2F 43 60 00 03 00 00 00"), "585 80 43 60 00 22 00 00 08");
  EXPECT_EQ(bench.answer("605 2F 43 60 00 04 00 00 00"), "585 60 43 60 00 00 00 00 00") << "the same";
  bench.image.status_word = 0x000B;
  EXPECT_EQ(bench.answer("605 2F 43 60 00 03 00 00 00"), "585 60 43 60 00 00 00 00 00") << "HOLD";
}

}  // namespace
}  // namespace plenum::canopen
