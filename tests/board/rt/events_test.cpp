// The kernel's events, by pipes that stand for devices. A wait that does not end would hang: ctest's limit ends it.
#include "board/rt/events.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <unistd.h>

#include <array>
#include <csignal>

namespace plenum::board::rt {
namespace {

constexpr std::uint64_t kNever_ns = 4'000'000'000'000'000'000;

class Pipe {
 public:
  Pipe() { EXPECT_EQ(::pipe(end_.data()), 0); }
  ~Pipe() {
    ::close(end_[0]);
    if (end_[1] >= 0) ::close(end_[1]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int descriptor() const { return end_[0]; }
  void bring() const { EXPECT_EQ(::write(end_[1], "x", 1), 1); }
  void go() {
    ::close(end_[1]);
    end_[1] = -1;
  }

 private:
  std::array<int, 2> end_{};
};

TEST(KernelEvents, AMomentThatHasComeEndsTheWaitAndNothingElseHasHappened) {
  KernelEvents events(-1, {});
  const std::uint64_t until_ns = events.now_ns() + 1'000'000;
  const Happened happened = events.wait(until_ns, WaitFor::anything);
  EXPECT_GE(events.now_ns(), until_ns);
  EXPECT_FALSE(happened.stop || happened.frames || happened.scans || happened.emergency_stop);
}

TEST(KernelEvents, EachDeviceIsToldFromTheOthers) {
  const Pipe stop;
  const Pipe bus;
  const std::array<Pipe, 2> converter;
  const std::array descriptors{converter[0].descriptor(), converter[1].descriptor()};
  KernelEvents events(stop.descriptor(), descriptors);
  events.watch_frames(bus.descriptor());

  converter[1].bring();
  Happened happened = events.wait(kNever_ns, WaitFor::anything);
  EXPECT_TRUE(happened.scans);
  EXPECT_FALSE(happened.frames || happened.emergency_stop || happened.stop);

  bus.bring();
  happened = events.wait(kNever_ns, WaitFor::anything);
  EXPECT_TRUE(happened.frames);
  EXPECT_FALSE(happened.emergency_stop);

  stop.bring();
  EXPECT_TRUE(events.wait(kNever_ns, WaitFor::anything).emergency_stop);
}

TEST(KernelEvents, DriversDoNotEndAWaitForTheMoment) {
  const Pipe bus;
  KernelEvents events(-1, {});
  events.watch_frames(bus.descriptor());
  bus.bring();
  const std::uint64_t until_ns = events.now_ns() + 1'000'000;
  EXPECT_FALSE(events.wait(until_ns, WaitFor::moment_or_stop).frames);
  EXPECT_GE(events.now_ns(), until_ns);
}

TEST(KernelEvents, ADeviceThatHasGoneEndsOneWaitAndNoMore) {
  Pipe converter;
  const std::array descriptors{converter.descriptor()};
  KernelEvents events(-1, descriptors);
  converter.go();
  EXPECT_TRUE(events.wait(kNever_ns, WaitFor::anything).scans);
  const std::uint64_t until_ns = events.now_ns() + 1'000'000;
  EXPECT_FALSE(events.wait(until_ns, WaitFor::anything).scans);
  EXPECT_GE(events.now_ns(), until_ns);
}

TEST(KernelEvents, TheSignalsThatAskToStopEndAWaitInsteadOfTheProgram) {
  block_stop_signals();
  KernelEvents events(-1, {});
  for (const int signal : {SIGTERM, SIGINT}) {
    ASSERT_EQ(::pthread_kill(::pthread_self(), signal), 0);
    EXPECT_TRUE(events.wait(kNever_ns, WaitFor::moment_or_stop).stop);
    const std::uint64_t until_ns = events.now_ns() + 1'000'000;
    EXPECT_FALSE(events.wait(until_ns, WaitFor::moment_or_stop).stop) << "told once";
  }
}

}  // namespace
}  // namespace plenum::board::rt
