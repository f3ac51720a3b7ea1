// When ticks are due, on a clock that the test moves.
#include "board/rt/pace.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace plenum::board::rt {
namespace {

constexpr std::uint64_t kPeriod = 10'000'000;
constexpr std::uint64_t kStart = 1'000'000'000;
constexpr std::uint64_t kSlip = kPeriod / Pace::kDrift;
constexpr Pace::Config kClock{.period_ns = kPeriod, .by_scans = false};
constexpr Pace::Config kScans{.period_ns = kPeriod, .by_scans = true};

TEST(PaceByClock, TicksAreDueAPeriodApartHoweverLateEachBegins) {
  Pace pace(kClock, kStart);
  std::uint64_t due_ns = kStart;
  for (const std::uint64_t late_ns : {0U, 900U, 70'000U, 9'999'999U, 0U}) {
    due_ns += kPeriod;
    EXPECT_EQ(pace.deadline_ns(true), due_ns);
    EXPECT_FALSE(pace.due(due_ns - 1, true)) << "scans call for nothing here";
    const auto tick = pace.due(due_ns + late_ns, false);
    ASSERT_TRUE(tick);
    EXPECT_EQ(tick->latency_ns, late_ns);
    EXPECT_EQ(tick->missed, 0U);
  }
}

TEST(PaceByClock, TicksThatWentByAreCountedAndNeverMadeUpFor) {
  Pace pace(kClock, kStart);
  const auto tick = pace.due(kStart + 4 * kPeriod + 5, false);
  ASSERT_TRUE(tick);
  EXPECT_EQ(tick->missed, 3U);
  EXPECT_EQ(tick->latency_ns, 3 * kPeriod + 5);
  EXPECT_FALSE(pace.due(kStart + 5 * kPeriod - 1, false));
  EXPECT_TRUE(pace.due(kStart + 5 * kPeriod, false));
}

TEST(PaceByScans, ATickBeginsWithItsScans) {
  Pace pace(kScans, kStart);
  std::uint64_t now_ns = kStart + 3'000'000;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(pace.due(now_ns - 1, false));
    const auto tick = pace.due(now_ns, true);
    ASSERT_TRUE(tick);
    EXPECT_EQ(tick->latency_ns, 0U);
    EXPECT_EQ(tick->missed, 0U);
    now_ns += kPeriod;
  }
}

TEST(PaceByScans, LatencyIsCountedFromTheEarliestPhase) {
  Pace pace(kScans, kStart);
  ASSERT_TRUE(pace.due(kStart + kPeriod, true));
  const auto late = pace.due(kStart + 2 * kPeriod + 300'000, true);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->latency_ns, 300'000 - kSlip);
  const auto in_time = pace.due(kStart + 3 * kPeriod, true);
  ASSERT_TRUE(in_time);
  EXPECT_EQ(in_time->latency_ns, 0U);
}

TEST(PaceByScans, ACrystalThatIsSlowerByADriftIsNoLatencyAndASlowerOneIsAnOverrunInTheEnd) {
  const auto run = [](std::uint64_t period_ns) {
    Pace pace(kScans, kStart);
    Pace::Tick sum;
    std::uint64_t now_ns = kStart;
    for (int i = 0; i < 2000; ++i) {
      now_ns += period_ns;
      const auto tick = pace.due(now_ns, true);
      EXPECT_TRUE(tick);
      if (!tick) break;
      sum.latency_ns += tick->latency_ns;
      sum.missed += tick->missed;
    }
    return sum;
  };
  const Pace::Tick as_good_as_crystals = run(kPeriod + kSlip);
  EXPECT_EQ(as_good_as_crystals.latency_ns, 0U);
  const Pace::Tick one_in_a_hundred = run(kPeriod + kPeriod / 100);
  // behind by 98 us a tick: a period after 102 ticks
  EXPECT_EQ(one_in_a_hundred.missed, 19U);
}

TEST(PaceByScans, WhenTheScansStayAwayTheClockStandsInHalfAPeriodLaterAndThenEveryPeriod) {
  Pace pace(kScans, kStart);
  ASSERT_TRUE(pace.due(kStart + kPeriod, true));
  const std::uint64_t expected_ns = kStart + 2 * kPeriod + kSlip;
  std::uint64_t clock_ns = expected_ns + kPeriod / 2;
  EXPECT_EQ(pace.deadline_ns(false), clock_ns);
  EXPECT_FALSE(pace.due(clock_ns - 1, false));
  const auto first = pace.due(clock_ns, false);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->latency_ns, kPeriod / 2);
  EXPECT_EQ(first->missed, 0U);
  for (int i = 0; i < 5; ++i) {
    clock_ns += kPeriod;
    EXPECT_FALSE(pace.due(clock_ns - 1, false));
    const auto tick = pace.due(clock_ns, false);
    ASSERT_TRUE(tick);
    EXPECT_EQ(tick->latency_ns, 0U);
    EXPECT_EQ(tick->missed, 0U);
  }
}

TEST(PaceByScans, ScansThatComeAgainPaceTheTicksAgain) {
  Pace pace(kScans, kStart);
  ASSERT_TRUE(pace.due(kStart + kPeriod, true));
  const std::uint64_t stood_in_ns = pace.deadline_ns(false);
  ASSERT_TRUE(pace.due(stood_in_ns, false));
  // A tick's worth of scans takes less than a period to come, so that they are there before the clock calls.
  const std::uint64_t again_ns = stood_in_ns + kPeriod - 400'000;
  const auto again = pace.due(again_ns, true);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->latency_ns, 0U);
  EXPECT_EQ(pace.deadline_ns(false), again_ns + kPeriod + kSlip + kPeriod / 2);
}

TEST(PaceByScans, AConverterTwiceAsFastAsItWasSaidToBeGainsAHundredthAndNoMore) {
  Pace pace(kScans, kStart);
  std::uint64_t scans_ns = kStart;
  std::uint64_t now_ns = kStart;
  bool ready = false;
  int ticks = 0;
  while (now_ns < kStart + 100 * kPeriod) {
    const std::uint64_t deadline_ns = pace.deadline_ns(ready);
    now_ns = std::min(scans_ns + kPeriod / 2, deadline_ns);  // as the loop waits
    if (now_ns == scans_ns + kPeriod / 2) {
      scans_ns = now_ns;
      ready = true;
    }
    const auto tick = pace.due(now_ns, ready);
    EXPECT_TRUE(tick || now_ns < deadline_ns) << "a wait that has ended for nothing";
    if (!tick) continue;
    EXPECT_EQ(tick->latency_ns, 0U);
    ready = false;
    ++ticks;
  }
  EXPECT_EQ(ticks, 101);
}

TEST(PaceByScans, AProcessThatWasStoppedFindsItsTicksMissedThoughScansWait) {
  Pace pace(kScans, kStart);
  ASSERT_TRUE(pace.due(kStart + kPeriod, true));
  const auto tick = pace.due(kStart + 5 * kPeriod, true);
  ASSERT_TRUE(tick);
  EXPECT_EQ(tick->missed, 2U);
  EXPECT_EQ(tick->latency_ns, 3 * kPeriod - kSlip);
}

}  // namespace
}  // namespace plenum::board::rt
