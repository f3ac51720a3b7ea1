#include "board/rt/only_one.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <stdexcept>

namespace plenum::board::rt {
namespace {

using std::chrono::steady_clock;

/// An interface that no other run of this test uses.
std::string interface() {
  return "plenum-" + std::to_string(::getpid());
}

std::string failure(const std::string& on) {
  try {
    const OnlyOne second(on, steady_clock::now());
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no failure";
}

TEST(OnlyOne, RefusesASecondOnTheSameInterfaceAndNoOther) {
  const OnlyOne first(interface(), steady_clock::now());
  EXPECT_EQ(failure(interface()), interface() + ": another plenumd runs on it, expected to be the only one");
  EXPECT_EQ(failure(interface() + "b"), "no failure");
}

TEST(OnlyOne, LetsTheNextOneFollow) {
  { const OnlyOne first(interface(), steady_clock::now()); }
  EXPECT_EQ(failure(interface()), "no failure");
}

TEST(OnlyOne, IsHeldByTheGuardOfTheOneThatHasEndedUntilItEnds) {
  std::array<int, 2> farewell{};
  ASSERT_EQ(::pipe(farewell.data()), 0);
  std::optional<OnlyOne> first(std::in_place, interface(), steady_clock::now());
  const std::string name = interface();
  const pid_t guard = ::fork();
  if (guard == 0) {
    ::close(farewell[1]);
    char none = 0;
    ::_exit(::read(farewell[0], &none, 1) == 0 ? 0 : 1);
  }
  first.reset();
  EXPECT_NE(failure(name), "no failure");
  ::close(farewell[1]);
  ASSERT_EQ(::waitpid(guard, nullptr, 0), guard);
  EXPECT_EQ(failure(name), "no failure");
  ::close(farewell[0]);
}

}  // namespace
}  // namespace plenum::board::rt
