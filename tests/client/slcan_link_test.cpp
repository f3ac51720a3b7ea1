// Our end of a serial adapter against one that follows a script on the other end of a pseudo-terminal.
#include "host-sim/client/slcan_link.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>

#include <functional>
#include <set>
#include <string>
#include <thread>

#include "tests/client/link_frames.hpp"

namespace plenum::host::client {
namespace {

using ::testing::HasSubstr;

constexpr double kSoon_s = 5.0;  ///< a deadline that is not reached

class Adapter {
 public:
  explicit Adapter(std::function<void(Adapter&)> script) : terminal_(::posix_openpt(O_RDWR | O_NOCTTY)) {
    ::grantpt(terminal_.number());
    ::unlockpt(terminal_.number());
    device_ = ::ptsname(terminal_.number());
    keeper_ = wire::FileDescriptor(
        ::open(device_.c_str(), O_RDWR | O_NOCTTY));  // no hang-up before and after the link
    thread_ = std::thread([this, script = std::move(script)] { script(*this); });
  }
  ~Adapter() { end(); }
  void end() {
    if (thread_.joinable()) thread_.join();
  }
  SlcanAddress address() const { return {.device = device_}; }

  /// The next line of the link, without its end.
  std::string hear() {
    std::string line;
    for (char byte = 0; byte != '\r';) {
      pollfd waiting{terminal_.number(), POLLIN, 0};
      if (::poll(&waiting, 1, 10'000) <= 0 || ::read(terminal_.number(), &byte, 1) != 1) return "nothing";
      if (byte != '\r') line += byte;
    }
    return line;
  }
  void say(std::string_view bytes) {
    ASSERT_EQ(::write(terminal_.number(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void hear_close() {
    for (const char* line : {"", "", "C"}) EXPECT_EQ(hear(), line) << "two ends of lines, then the command";
  }
  void open(const char* rate = "S8") {
    hear_close();
    say("\a");  // it was closed already
    EXPECT_EQ(hear(), rate);
    say("\r");
    EXPECT_EQ(hear(), "O");
    say("\r");
  }

 private:
  wire::FileDescriptor terminal_;
  wire::FileDescriptor keeper_;
  std::string device_;
  std::thread thread_;
};

TEST(SlcanLink, SetsTheRateOpensCarriesFramesBothWaysAndCloses) {
  Adapter adapter([](Adapter& it) {
    it.open();
    EXPECT_EQ(it.hear(), "t60584000100000000000");
    it.say("z\rt58584300100098010000\rT000000122AB");  // the rest comes with the next piece
    it.say("CD\r");
    EXPECT_EQ(it.hear(), "C");
  });
  SlcanLink link(adapter.address());
  link.send(frame_of(0x605, {0x40, 0x00, 0x10, 0, 0, 0, 0, 0}));
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x585, {0x43, 0x00, 0x10, 0x00, 0x98, 0x01, 0x00, 0x00}));
  const auto extended = link.receive(kSoon_s);
  ASSERT_TRUE(extended);
  EXPECT_TRUE(extended->extended);
  EXPECT_EQ(extended->id, 0x12U);
}

TEST(SlcanLink, TheBitRateIsThatOfTheAddress) {
  Adapter adapter([](Adapter& it) {
    it.open("S6");
    EXPECT_EQ(it.hear(), "C");
  });
  SlcanAddress address = adapter.address();
  address.bit_rate = 500'000;
  SlcanLink link(address);
}

TEST(SlcanLink, AnAdapterThatAnswersNoCommandIsTakenToAgree) {
  Adapter adapter([](Adapter& it) {
    it.hear_close();
    for (const char* command : {"S8", "O"}) EXPECT_EQ(it.hear(), command);
    it.say("t1810\r");
    EXPECT_EQ(it.hear(), "C");
  });
  SlcanLink link(adapter.address());
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x181, {}));
}

TEST(SlcanLink, ARateThatTheAdapterRefusesIsTold) {
  Adapter adapter([](Adapter& it) {
    it.hear_close();
    it.say("\r");
    EXPECT_EQ(it.hear(), "S8");
    it.say("\a");
  });
  EXPECT_THAT(failure([&] { SlcanLink link(adapter.address()); }),
              HasSubstr("refuses S8, expected one that has 1000000"));
}

TEST(SlcanLink, WhatAnEarlierUserHasBegunIsEndedAndItsAnswersAreNotTakenForOthers) {
  Adapter adapter([](Adapter& it) {
    EXPECT_EQ(it.hear(), "");
    it.say("\a");  // "t18" and this end of a line are no frame
    EXPECT_EQ(it.hear(), "");
    it.say("\rt1810\r");  // its bus is open still
    EXPECT_EQ(it.hear(), "C");
    it.say("\r");
    EXPECT_EQ(it.hear(), "S8");
    it.say("\r");
    EXPECT_EQ(it.hear(), "O");
    it.say("\rt1820\r");
    EXPECT_EQ(it.hear(), "C");
  });
  SlcanLink link(adapter.address());
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x182, {}));
}

// As CANable's: room for some frames, of which the bus takes one while so many are offered; a bell where there is none.
TEST(SlcanLink, FramesThatFindNoRoomAreOfferedAgainAndAllArrive) {
  constexpr std::size_t kFrames = 97;
  std::multiset<std::string> taken;
  Adapter adapter([&](Adapter& it) {
    it.open();
    std::size_t waiting = 0;
    for (std::size_t offered = 0;; ++offered) {
      const std::string line = it.hear();
      if (line == "C") return;
      if (offered % 3 == 0 && waiting > 0) --waiting;
      const bool room = waiting < 28;
      if (room) taken.insert(line);
      waiting += room ? 1 : 0;
      it.say(!room ? "\a" : offered % 10 == 0 ? "t1810\rz\r" : "z\r");
    }
  });
  {
    SlcanLink link(adapter.address());
    for (std::size_t k = 0; k < kFrames; ++k) link.send(frame_of(0x605, {static_cast<std::uint8_t>(k)}));
    while (link.receive(0.05)) continue;  // also what is still refused
  }
  adapter.end();
  EXPECT_EQ(taken.size(), kFrames);
  for (std::size_t k = 0; k < kFrames; ++k) EXPECT_EQ(taken.count(fmt::format("t6051{:02X}", k)), 1U) << k;
}

TEST(SlcanLink, AnAdapterThatAnswersNoFrameGetsThemAll) {
  constexpr int kFrames = 40;
  Adapter adapter([](Adapter& it) {
    it.open();
    for (int k = 0; k < kFrames; ++k) EXPECT_EQ(it.hear(), fmt::format("t6051{:02X}", k));
    EXPECT_EQ(it.hear(), "C");
  });
  SlcanLink link(adapter.address());
  for (int k = 0; k < kFrames; ++k) link.send(frame_of(0x605, {static_cast<std::uint8_t>(k)}));
}

TEST(SlcanLink, AFrameThatTheAdapterRefusesForASecondIsTold) {
  Adapter adapter([](Adapter& it) {
    it.open();
    for (std::string line = it.hear(); line != "C"; line = it.hear()) {
      EXPECT_EQ(line, "t0000");
      it.say("\a");
    }
  });
  SlcanLink link(adapter.address());
  link.send(frame_of(0, {}));
  EXPECT_THAT(failure([&] { link.receive(kSoon_s); }), HasSubstr("refused a frame"));
}

TEST(SlcanLink, WhatIsNoTerminalIsRefused) {
  EXPECT_THAT(
      failure([] { SlcanLink link({.device = "/dev/null"}); }),
      HasSubstr("slcan:/dev/null@1000000: is no terminal, expected the terminal of a serial CAN adapter"));
  EXPECT_THAT(failure([] { SlcanLink link({.device = "/dev/nosuchtty"}); }),
              HasSubstr("No such file or directory"));
}

}  // namespace
}  // namespace plenum::host::client
