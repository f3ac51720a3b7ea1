#include "board/rt/watchdog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace plenum::board::rt {
namespace {

/// Answers for the driver of a watchdog, for whose device a file stands.
struct Driver {
  std::optional<int> made_s;  ///< of what WDIOC_SETTIMEOUT asks for; empty: it sets none
  int has_s;
};
std::optional<Driver> driver;

}  // namespace
}  // namespace plenum::board::rt

/// In the place of the C library's.
extern "C" int ioctl(int file, unsigned long request, ...) noexcept {
  std::va_list more;
  va_start(more, request);
  void* const argument = va_arg(more, void*);
  va_end(more);
  const auto& driver = plenum::board::rt::driver;
  if (!driver || (request != WDIOC_SETTIMEOUT && request != WDIOC_GETTIMEOUT))
    return static_cast<int>(::syscall(SYS_ioctl, file, request, argument));
  const std::optional<int> answer = request == WDIOC_SETTIMEOUT ? driver->made_s : driver->has_s;
  if (!answer) {
    errno = EOPNOTSUPP;
    return -1;
  }
  *static_cast<int*>(argument) = *answer;
  return 0;
}

namespace plenum::board::rt {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(FeedingTime, ComesAfterTheIntervalAndOnlyWithANewTick) {
  FeedingTime feeding(100);
  EXPECT_FALSE(feeding.due(1000, 0)) << "no tick has been done";
  EXPECT_TRUE(feeding.due(1000, 1));
  EXPECT_FALSE(feeding.due(1099, 2)) << "too early";
  EXPECT_TRUE(feeding.due(1100, 2));
  EXPECT_FALSE(feeding.due(5000, 2)) << "the ticks stand still";
  EXPECT_TRUE(feeding.due(5001, 3));
}

TEST(FeedingTime, NeverComesWithoutAnInterval) {
  FeedingTime feeding(0);
  EXPECT_FALSE(feeding.due(1'000'000, 5));
}

/// The service manager's end: an abstract socket, named in the environment as systemd does.
class ServiceManagerTest : public testing::Test {
 protected:
  void SetUp() override {
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const std::string name = "plenum-watchdog-test-" + std::to_string(::getpid());
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    name.copy(address.sun_path + 1, sizeof address.sun_path - 1);
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    ASSERT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), length), 0);
    ::setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
    ::setenv("WATCHDOG_USEC", "300", 1);
    ::setenv("WATCHDOG_PID", std::to_string(::getpid()).c_str(), 1);
  }
  void TearDown() override {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) ::unsetenv(name);
    ::close(socket_);
  }

  /// As many messages as it holds unread.
  void fill() const {
    sockaddr_un address{};
    socklen_t length = sizeof address;
    ASSERT_EQ(::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length), 0);
    const int other = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    while (::sendto(other, "x", 1, 0, reinterpret_cast<const sockaddr*>(&address), length) == 1) continue;
    EXPECT_EQ(errno, EAGAIN);
    ::close(other);
  }

  std::vector<std::string> said() const {
    std::vector<std::string> all;
    std::array<char, 64> text{};
    for (ssize_t length = 0; (length = ::recv(socket_, text.data(), text.size(), 0)) >= 0;)
      all.emplace_back(text.data(), static_cast<std::size_t>(length));
    return all;
  }

  std::vector<std::string> said_at_the_first_tick() const {
    ServiceManager manager;
    manager.ticked(1'000'000, 1);
    return said();
  }

 private:
  int socket_ = -1;
};

TEST_F(ServiceManagerTest, IsToldReadyAtTheFirstTickAndFedThreeTimesInTheTimeAllowedWhileTicksAdvance) {
  ServiceManager manager;
  EXPECT_THAT(said(), IsEmpty());
  manager.ticked(1'000'000, 1);
  EXPECT_THAT(said(), ElementsAre("READY=1", "WATCHDOG=1"));
  manager.ticked(1'099'999, 2);
  EXPECT_THAT(said(), IsEmpty());
  manager.ticked(1'100'000, 3);
  EXPECT_THAT(said(), ElementsAre("WATCHDOG=1"));
  manager.ticked(9'000'000, 3);
  EXPECT_THAT(said(), IsEmpty());
  manager.stopping();
  EXPECT_THAT(said(), ElementsAre("STOPPING=1"));
}

TEST_F(ServiceManagerTest, IsNotFedWhenItDoesNotAskForIt) {
  ::unsetenv("WATCHDOG_USEC");
  EXPECT_THAT(said_at_the_first_tick(), ElementsAre("READY=1"));
}

TEST_F(ServiceManagerTest, IsNotFedForAnotherProcess) {
  ::setenv("WATCHDOG_PID", "1", 1);
  EXPECT_THAT(said_at_the_first_tick(), ElementsAre("READY=1"));
}

// a tick that waited here would hang the test
TEST_F(ServiceManagerTest, OneThatDoesNotReadKeepsNoTickAndIsToldWhenItReadsAgain) {
  ServiceManager manager;
  fill();
  manager.ticked(1'000'000, 1);
  said();
  manager.ticked(1'000'001, 2);
  EXPECT_THAT(said(), ElementsAre("READY=1"));
  manager.ticked(1'100'000, 3);
  EXPECT_THAT(said(), ElementsAre("WATCHDOG=1"));
}

TEST(ServiceManager, OneThatIsNotThereIsNotMissed) {
  ::setenv("NOTIFY_SOCKET", "/nowhere/notify", 1);
  ServiceManager manager;
  manager.ticked(1'000'000, 1);
  manager.stopping();
  ::unsetenv("NOTIFY_SOCKET");
}

TEST(HardwareWatchdog, ADeviceThatIsNoneIsNamed) {
  try {
    HardwareWatchdog watchdog("/dev/null");
    FAIL() << "taken for a watchdog";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "/dev/null: Inappropriate ioctl for device, expected a watchdog that takes 5 s");
  }
}

class HardwareWatchdogTest : public testing::Test {
 protected:
  HardwareWatchdogTest() { std::ofstream{path_}; }
  ~HardwareWatchdogTest() override {
    driver.reset();
    std::filesystem::remove(path_);
  }

  /// All that has been written to the device.
  std::string written() const {
    std::ostringstream text;
    text << std::ifstream(path_, std::ios::binary).rdbuf();
    return text.str();
  }

  const std::string path_ =
      std::filesystem::temp_directory_path() / ("plenum-watchdog-" + std::to_string(::getpid()));
};

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

TEST_F(HardwareWatchdogTest, IsFedThreeTimesInItsTimeAndDisarmedAtTheEnd) {
  driver = {.made_s = 5, .has_s = 5};
  {
    HardwareWatchdog watchdog(path_);
    EXPECT_EQ(watchdog.trouble(), "");
    watchdog.ticked(100 * kSecond_ns, 1);
    watchdog.ticked(101 * kSecond_ns, 2);
    EXPECT_EQ(written(), std::string(1, '\0')) << "a second later";
    watchdog.ticked(102 * kSecond_ns, 3);
    EXPECT_EQ(written(), std::string(2, '\0')) << "two seconds later";
  }
  EXPECT_EQ(written(), std::string("\0\0V", 3));
}

TEST_F(HardwareWatchdogTest, OneWhoseDriverRoundsTheTimeIsFedInThatTimeAndToldOf) {
  driver = {.made_s = 16, .has_s = 16};
  HardwareWatchdog longer(path_);
  EXPECT_EQ(longer.timeout_s(), 16);
  EXPECT_EQ(longer.trouble(), path_ + ": resets the machine after 16 s without a tick, expected 5");
  driver = {.made_s = 1, .has_s = 1};
  HardwareWatchdog shorter(path_);
  EXPECT_EQ(shorter.trouble(), path_ + ": resets the machine after 1 s without a tick, expected 5");
  shorter.ticked(100 * kSecond_ns, 1);
  shorter.ticked(100 * kSecond_ns + kSecond_ns / 3, 2);
  EXPECT_EQ(written(), std::string(2, '\0'));
}

TEST_F(HardwareWatchdogTest, OneThatKnowsOnlyItsOwnTimeStaysArmedAndIsFedInIt) {
  driver = {.made_s = std::nullopt, .has_s = 60};
  HardwareWatchdog watchdog(path_);
  EXPECT_EQ(watchdog.timeout_s(), 60);
  EXPECT_EQ(written(), "") << "not disarmed";
  EXPECT_EQ(watchdog.trouble(), path_ + ": resets the machine after 60 s without a tick, expected 5");
}

TEST(HardwareWatchdog, OneThatIsNotWantedIsNotFed) {
  HardwareWatchdog none("");
  none.ticked(100 * kSecond_ns, 1);
  EXPECT_EQ(none.trouble(), "");
}

}  // namespace
}  // namespace plenum::board::rt
