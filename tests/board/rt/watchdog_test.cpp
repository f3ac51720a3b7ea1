#include "board/rt/watchdog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

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

  std::vector<std::string> said() const {
    std::vector<std::string> all;
    std::array<char, 64> text{};
    for (ssize_t length = 0; (length = ::recv(socket_, text.data(), text.size(), 0)) >= 0;)
      all.emplace_back(text.data(), static_cast<std::size_t>(length));
    return all;
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
  ServiceManager manager;
  manager.ticked(1'000'000, 1);
  EXPECT_THAT(said(), ElementsAre("READY=1"));
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

}  // namespace
}  // namespace plenum::board::rt
