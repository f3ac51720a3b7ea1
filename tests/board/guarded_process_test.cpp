// A guard and what it guards, as real processes that write to the stand-in for the kernel's attributes. No test waits for a
// time: what all processes of a scene have said ends when the last of them does.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include "board/drivers/iio_output.hpp"
#include "board/guard.hpp"
#include "board/rt/events.hpp"
#include "tests/board/drivers/iio_stand_in.hpp"

namespace plenum::board {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const std::string kDac = "iio:device0";
const std::string kMoved = "6554";  // 1 V / 10 V x 65536
const std::string kSafe = "32768";  // 5 V
constexpr std::uint64_t kTick_ns = 10'000'000;
constexpr std::uint64_t kNever_ns = 4'000'000'000'000'000'000;

struct Valve final : SafeOutputs {
  void make_safe() noexcept override { output.make_safe(); }
  void move() { EXPECT_TRUE(output.write(std::array{1.0F})); }

  drivers::IioOutput output{{.channels = {{"ad5755", "voltage0"}}, .safe_V = {5.0F}}};
};

constexpr Guard::Config kMinds{.silence_ns = 5 * kTick_ns, .priority = 0};

/// The only child of a process.
pid_t child_of(pid_t parent) {
  const std::string folder = "/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent);
  pid_t child = -1;
  std::ifstream(folder + "/children") >> child;
  return child;
}

class GuardedProcess : public drivers::IioStandIn {
 protected:
  void SetUp() override {
    IioStandIn::SetUp();
    if (IsSkipped()) return;
    add_device(kDac, "ad5755");
    put(kDac, "out_voltage0_raw", "777");
    put(kDac, "out_voltage0_scale", "0.152587890");
    ::prctl(PR_SET_CHILD_SUBREAPER, 1);  // a guard whose loop has ended is this process's child
    ASSERT_EQ(::pipe2(said_.data(), O_CLOEXEC), 0);
  }
  ~GuardedProcess() override {
    while (::waitpid(-1, nullptr, 0) > 0) {
    }
    for (const int end : said_) ::close(end);
  }

  /// A process that does this, with its errors in a pipe, and ends with 0.
  void start(const std::function<void()>& does) {
    loop_ = ::fork();
    if (loop_ != 0) {
      ::close(said_[1]);
      said_[1] = -1;
      return;
    }
    ::dup2(said_[1], STDERR_FILENO);
    does();
    ::_exit(0);
  }

  void wait_for(const std::string& line) {
    while (text_.find(line) == std::string::npos) ASSERT_TRUE(more());
  }

  /// What was said, when each process has ended.
  std::string said() {
    while (more()) {
    }
    return text_;
  }

  /// The signal that ended it; 0: it ended by itself.
  int killed_by() const {
    int status = -1;
    EXPECT_EQ(::waitpid(loop_, &status, 0), loop_);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

  static std::string raw() { return text(kDac, "out_voltage0_raw"); }

  pid_t loop_ = -1;

 private:
  bool more() {
    std::array<char, 256> bytes{};
    const ssize_t count = ::read(said_[0], bytes.data(), bytes.size());
    if (count > 0) text_.append(bytes.data(), static_cast<std::size_t>(count));
    return count > 0;
  }

  std::array<int, 2> said_{-1, -1};
  std::string text_;
};

/// Moves the valve under guard, says so, and waits for what is done to it.
void move_and_wait() {
  Valve valve;
  const Guard guard(kMinds, valve);
  valve.move();
  ASSERT_EQ(::write(STDERR_FILENO, "moved\n", 6), 6);
  for (;;) ::pause();
}

TEST_F(GuardedProcess, KilledItLeavesTheOutputsSafe) {
  start(move_and_wait);
  wait_for("moved\n");
  ASSERT_EQ(raw(), kMoved);
  ASSERT_EQ(::kill(loop_, SIGKILL), 0);
  EXPECT_THAT(said(), HasSubstr("ended without a farewell"));
  EXPECT_EQ(raw(), kSafe);
}

TEST_F(GuardedProcess, TheEndOfTheLoopsThreadIsEnoughWhileAnotherLivesOn) {
  start([] {
    Valve valve;
    const Guard guard(kMinds, valve);
    valve.move();
    std::thread([] {
      for (;;) ::pause();
    }).detach();
    ::syscall(SYS_exit, 0);
  });
  wait_for("ended without a farewell");
  EXPECT_EQ(raw(), kSafe);
  ASSERT_EQ(::kill(loop_, SIGKILL), 0);
}

TEST_F(GuardedProcess, WhatAsksTheServiceToEndDoesNotEndTheGuard) {
  start(move_and_wait);
  wait_for("moved\n");
  const pid_t guard = child_of(loop_);
  ASSERT_GT(guard, 0);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGTSTP}) ASSERT_EQ(::kill(guard, signal), 0);
  EXPECT_NE(::getpgid(guard), ::getpgid(loop_)) << "the group of a terminal";
  ASSERT_EQ(::kill(loop_, SIGKILL), 0);
  said();
  EXPECT_EQ(raw(), kSafe);
}

TEST_F(GuardedProcess, StoppedItIsKilledAndLeavesTheOutputsSafe) {
  start([] {
    Valve valve;
    Guard guard(kMinds, valve);
    valve.move();
    guard.beat();
    ::raise(SIGSTOP);
    valve.move();
  });
  EXPECT_THAT(said(), HasSubstr("was silent"));
  EXPECT_EQ(killed_by(), SIGKILL);
  EXPECT_EQ(raw(), kSafe);
}

TEST_F(GuardedProcess, AfterAFarewellNothingIsWritten) {
  start([] {
    Valve valve;
    {
      Guard guard(kMinds, valve);
      guard.rest();
    }
    valve.move();
    ::_exit(0);
  });
  EXPECT_THAT(said(), IsEmpty());
  EXPECT_EQ(killed_by(), 0);
  EXPECT_EQ(::waitpid(-1, nullptr, 0), -1) << "the guard is left";
  EXPECT_EQ(raw(), kMoved);
}

TEST_F(GuardedProcess, AGuardThatHasEndedOrWasStoppedIsMissedByTheLoop) {
  rt::block_stop_signals();
  for (const int signal : {SIGKILL, SIGSTOP}) {
    Valve valve;
    const Guard guard(kMinds, valve);
    rt::KernelEvents events(-1, {});
    EXPECT_TRUE(guard.stands());
    ASSERT_EQ(::kill(child_of(::getpid()), signal), 0);
    do EXPECT_TRUE(events.wait(kNever_ns, rt::WaitFor::anything).child);
    while (guard.stands());
  }
}

}  // namespace
}  // namespace plenum::board
