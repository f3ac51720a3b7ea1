// The loop on a clock that the test moves, with drivers of memory.
#include "board/plenumd.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "tests/firmware/board/bench.hpp"

namespace plenum::board {
namespace {

using testing::Each;
using testing::ElementsAre;

constexpr std::uint64_t kMs = 1'000'000;
constexpr std::uint64_t kStart = 5'000 * kMs;

/// Something that comes from a driver at a moment.
struct Event {
  std::uint64_t at_ns;
  rt::Happened happened;
  std::function<void()> also = {};
};

class FakeEvents final : public rt::Events {
 public:
  std::uint64_t now_ns() noexcept override { return now; }

  rt::Happened wait(std::uint64_t until_ns, rt::WaitFor what) noexcept override {
    waits.push_back(what);
    const auto counts = [&](const Event& one) {
      return one.at_ns <= until_ns && (what == rt::WaitFor::anything || one.happened.stop);
    };
    const auto next = std::find_if(events.begin(), events.end(), counts);
    if (next == events.end()) {
      now = std::max(now, until_ns);
      return always;
    }
    const Event event = *next;
    events.erase(next);
    now = std::max(now, event.at_ns);
    if (event.also) event.also();
    return event.happened;
  }

  void stop_after(std::uint64_t ms) { events.push_back({kStart + ms * kMs, {.stop = true}}); }

  std::uint64_t now = kStart;
  std::vector<Event> events;  ///< in the order of time
  rt::Happened always;        ///< told with every moment that comes
  std::vector<rt::WaitFor> waits;
};

class FakeHardware final : public Hardware {
 public:
  void begin() noexcept override { begun = true; }
  bool gather() noexcept override {
    ready = true;
    return true;
  }
  bool scans_ready() const noexcept override { return ready; }
  void look_at_stop() noexcept override { looked_at_tick.push_back(ticks.size()); }
  bool guarded() const noexcept override { return guard; }
  void ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept override {
    EXPECT_TRUE(begun) << "with scans of before the first tick";
    EXPECT_EQ(tick_count, ticks.size() + 1);
    ticks.push_back(now_ns - kStart);
    ready = false;
  }
  void make_safe() noexcept override { safe_at_tick.push_back(ticks.size()); }
  void rest_at(std::size_t chamber, float command_V) noexcept override { resting_V.at(chamber) = command_V; }
  void stopping() noexcept override { when_stopping(); }

  bool begun = false;
  bool guard = true;
  bool ready = false;
  std::vector<std::uint64_t> ticks;  ///< when each was done [ns since the start]
  std::vector<std::size_t> looked_at_tick;
  std::vector<std::size_t> safe_at_tick;
  std::array<float, plenum::config::kChambers> resting_V{};
  std::function<void()> when_stopping = [] {};
};

class PlenumdTest : public testing::Test {
 protected:
  void run(const config::RealTime& real_time) {
    Plenumd loop(real_time, bench.board, events, hardware);
    loop.run();
  }
  const canopen::ProcessImage& image() const { return bench.image(); }

  Bench bench;
  FakeEvents events;
  FakeHardware hardware;
};

constexpr config::RealTime kClock{.pacing = config::Pacing::timer};
constexpr config::RealTime kAdc{.pacing = config::Pacing::adc};

TEST_F(PlenumdTest, ByTheClockItTicksEveryTenMilliseconds) {
  events.stop_after(55);
  run(kClock);
  EXPECT_THAT(hardware.ticks, ElementsAre(10 * kMs, 20 * kMs, 30 * kMs, 40 * kMs, 50 * kMs));
}

TEST_F(PlenumdTest, ByTheScansItTicksWhenTheyHaveCome) {
  for (const std::uint64_t ms : {7U, 17U, 27U}) events.events.push_back({kStart + ms * kMs, {.scans = true}});
  events.stop_after(28);
  run(kAdc);
  EXPECT_THAT(hardware.ticks, ElementsAre(7 * kMs, 17 * kMs, 27 * kMs));
}

TEST_F(PlenumdTest, WhenTheConverterStandsStillItTicksOnAndTheBoardGoesSafe) {
  bench.go_active(300.0);
  hardware.ticks.resize(static_cast<std::size_t>(bench.ticks));
  for (ports::AnalogReading& reading : bench.analog_in.reading) reading = {};
  const std::size_t before = hardware.ticks.size();
  events.stop_after(46);
  run(kAdc);
  EXPECT_EQ(hardware.ticks.size() - before, 4U);
  EXPECT_EQ(bench.state(), safety::State::fault_disabled);
  EXPECT_THAT(bench.analog_out.held_V, Each(5.0F));
}

TEST_F(PlenumdTest, FramesAreAnsweredBetweenTheTicks) {
  bench.board.start();
  bench.can.from_board.clear();
  std::vector<std::size_t> answers;
  events.events.push_back(
      {kStart + 3 * kMs, {.frames = true}, [&] {
         ports::CanFrame request{.id = 0x605, .length = 8, .data = {0x40, 0x00, 0x10, 0x00}};
         bench.can.to_board.push_back(request);
       }});
  events.events.push_back({kStart + 4 * kMs, {}, [&] { answers.push_back(bench.can.from_board.size()); }});
  events.stop_after(5);
  run(kClock);
  EXPECT_TRUE(hardware.ticks.empty());
  ASSERT_FALSE(bench.can.from_board.empty());
  EXPECT_EQ(bench.can.from_board.back().id, 0x585U);
  EXPECT_GE(answers.at(0), 1U);
}

TEST_F(PlenumdTest, TheEmergencyStopIsLookedAtWhenItComes) {
  events.events.push_back({kStart + 13 * kMs, {.emergency_stop = true}});
  events.stop_after(15);
  run(kClock);
  EXPECT_THAT(hardware.looked_at_tick, ElementsAre(1U));
}

TEST_F(PlenumdTest, TheOutputsAreSafeBeforeTheFirstTickAndAfterTheLast) {
  events.stop_after(35);
  run(kClock);
  EXPECT_THAT(hardware.safe_at_tick, ElementsAre(0U, 3U));
}

TEST_F(PlenumdTest, AChildThatHasEndedEndsItOnlyIfItWasTheGuard) {
  events.events.push_back({kStart + 13 * kMs, {.child = true}});
  events.events.push_back({kStart + 25 * kMs, {.child = true}, [this] { hardware.guard = false; }});
  events.stop_after(100);
  run(kClock);
  EXPECT_THAT(hardware.ticks, ElementsAre(10 * kMs, 20 * kMs));
  EXPECT_THAT(hardware.safe_at_tick, ElementsAre(0U, 2U));
}

TEST_F(PlenumdTest, ScansThatComeBeforeTheirTimeWaitForTheTick) {
  for (const std::uint64_t ms : {7U, 12U, 17U}) events.events.push_back({kStart + ms * kMs, {.scans = true}});
  events.stop_after(18);
  run(kAdc);
  EXPECT_THAT(hardware.ticks, ElementsAre(7 * kMs, 16'902'000U))
      << "a drift, and a hundredth of a tick before";
}

/// "save" to 1010h:1, at the third millisecond.
Event order_to_save(Bench& bench) {
  return {kStart + 3 * kMs, {.frames = true}, [&bench] {
            const ports::CanFrame save{
                .id = 0x605, .length = 8, .data = {0x23, 0x10, 0x10, 0x01, 's', 'a', 'v', 'e'}};
            bench.can.to_board.push_back(save);
          }};
}

TEST_F(PlenumdTest, WhatIsBeingStoredIsFinishedBeforeTheEnd) {
  bench.board.start();
  bench.store.patience = 5;
  events.events.push_back(order_to_save(bench));
  events.stop_after(11);
  run(kClock);
  EXPECT_EQ(image().store.phase, canopen::StorePhase::idle);
  EXPECT_EQ(image().store.generation, 1U);
}

TEST_F(PlenumdTest, ModelsThatCouldNotBeStoredAreTriedAgainBeforeTheEnd) {
  bench.board.start();
  bench.session.upload_models(std::array{host::client::ModelUpload{0, image_of(kValve, 7)}});
  hardware.ticks.resize(static_cast<std::size_t>(bench.ticks));
  bench.store.refuses = true;
  events.stop_after(31);
  hardware.when_stopping = [&] {
    EXPECT_EQ(image().store.phase, canopen::StorePhase::failing);
    bench.store.refuses = false;
  };
  run(kClock);
  EXPECT_EQ(image().store.phase, canopen::StorePhase::idle);
  EXPECT_EQ(image().store.generation, 1U);
}

TEST_F(PlenumdTest, TheOutputsRestWhereTheSettingsInForceSay) {
  bench.can.to_board.push_back(  // null_V of chamber 1
      {.id = 0x605,
       .length = 8,
       .data = {0x23, 0x00, 0x24, 0x0F, 0x00, 0x00, 0x90, 0x40}});  // 2400h:15 = 4.5
  events.stop_after(15);
  run(kClock);
  EXPECT_EQ(hardware.resting_V[0], 4.5F);
  EXPECT_EQ(hardware.resting_V[1], 5.0F);
}

TEST_F(PlenumdTest, TheServiceManagerIsToldOfTheEndOnceTheOutputsAreSafeAndBeforeStoringIsFinished) {
  bench.board.start();
  bench.store.patience = 5;
  events.events.push_back(order_to_save(bench));
  events.stop_after(11);
  int told = 0;
  hardware.when_stopping = [&] {
    ++told;
    EXPECT_EQ(hardware.safe_at_tick.size(), 2U);
    EXPECT_EQ(image().store.phase, canopen::StorePhase::writing);
  };
  run(kClock);
  EXPECT_EQ(told, 1);
}

TEST_F(PlenumdTest, AStoreThatNeverAnswersKeepsItFromEndingForTwoSecondsAndNoLonger) {
  bench.board.start();
  bench.store.patience = 1'000'000;
  events.events.push_back(order_to_save(bench));
  events.stop_after(11);
  run(kClock);
  EXPECT_EQ(image().store.phase, canopen::StorePhase::writing);
  EXPECT_EQ(events.now, kStart + (11 + Plenumd::kFinish_ms) * kMs);
}

class OverrunTest : public PlenumdTest {
 protected:
  /// `count` ticks in a row that each begin 25 ms after they were due.
  void run_late(Overrun policy, int count) {
    for (int i = 0; i < count; ++i) {
      const std::uint64_t at_ns = kStart + static_cast<std::uint64_t>(10 + 30 * i) * kMs;
      events.events.push_back({at_ns, {}, [this, at_ns] { events.now = at_ns + 25 * kMs; }});
    }
    events.stop_after(static_cast<std::uint64_t>(30 * count) + 6);
    run({.pacing = config::Pacing::timer, .overrun = policy});
  }
};

TEST_F(OverrunTest, TicksThatWentByAreNotMadeUpFor) {
  run_late(Overrun::counted, 3);
  EXPECT_THAT(hardware.ticks, ElementsAre(35 * kMs, 65 * kMs, 95 * kMs));
}

TEST_F(OverrunTest, SkippedOnesAreNotCounted) {
  run_late(Overrun::none, 3);
  EXPECT_EQ(image().overrun_count, 0U);
  EXPECT_EQ(image().error_code, 0U);
}

TEST_F(OverrunTest, CountedOnesMakeNoFault) {
  run_late(Overrun::counted, 3);
  EXPECT_EQ(image().overrun_count, 3U);
  EXPECT_EQ(image().error_code, 0U);
}

TEST_F(OverrunTest, ThreeOnEndAreAFault) {
  run_late(Overrun::fault, 3);
  EXPECT_EQ(image().overrun_count, 3U);
  EXPECT_EQ(image().error_code, 0xFF01U);
}

TEST_F(OverrunTest, SetPointsThatEndAreMissedInTheirTimeThoughTicksAreLeftOut) {
  bench.go_active(300.0);  // set points every tick, missed after ten
  hardware.ticks.resize(static_cast<std::size_t>(bench.ticks));
  events.events.push_back({kStart + 96 * kMs, {}, [this] { EXPECT_EQ(image().error_code, 0U) << "95 ms"; }});
  run_late(Overrun::counted, 4);
  EXPECT_EQ(image().error_code, 0x8250U) << "125 ms";
}

TEST_F(OverrunTest, AMasterThatWasHeardInEachTickIsNotMissedHoweverManyAreLeftOut) {
  bench.session.write(0x1016, 1, std::uint32_t{1U << 16 | 20U});  // node 1, 20 ms
  bench.session.write(canopen::object::kRpdoCommunication, 5, std::uint16_t{20});
  bench.session.write(canopen::object::kRpdoCommunication + 1, 5, std::uint16_t{20});
  bench.go_active(300.0);
  hardware.ticks.resize(static_cast<std::size_t>(bench.ticks));
  for (int i = 0; i < 4; ++i) {  // while the board is late, ahead of its tick
    events.events.push_back({kStart + static_cast<std::uint64_t>(9 + 30 * i) * kMs, {}, [this] {
                               bench.put(0x701, {5});
                               bench.setpoints(300.0);
                             }});
  }
  run_late(Overrun::counted, 4);
  EXPECT_EQ(image().error_code, 0U);
}

TEST_F(OverrunTest, LatencyIsKnownOnTheBus) {
  run_late(Overrun::none, 3);
  EXPECT_EQ(image().latency.max_us(), 25'000U);
  EXPECT_EQ(image().latency.count(telemetry::LatencyHistogram::bin_of(25'000)), 3U);
}

TEST_F(PlenumdTest, TheAgeOfTheNewestScanIsKnownOnTheBus) {
  events.events.push_back({kStart + 3 * kMs, {.scans = true}});
  events.stop_after(25);
  run(kClock);
  EXPECT_EQ(image().scan_age_us, 17'000U);
}

TEST_F(PlenumdTest, ADriverThatEndsEveryWaitAtOnceTakesNoTickAway) {
  for (int i = 0; i < 5 * Plenumd::kWaits; ++i) events.events.push_back({kStart, {.frames = true}});
  events.stop_after(25);
  run(kClock);
  EXPECT_THAT(hardware.ticks, ElementsAre(10 * kMs, 20 * kMs));
  EXPECT_EQ(std::count(events.waits.begin(), events.waits.end(), rt::WaitFor::moment_or_stop), 3);
}

}  // namespace
}  // namespace plenum::board
