// The kernel's answer to RTM_GETLINK, its bytes written by hand after rtnetlink(7) and linux/can/netlink.h; and a question to this
// machine's kernel about an interface that is no CAN.
#include "board/drivers/can_bit_rate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <initializer_list>
#include <string>
#include <vector>

namespace plenum::board::drivers {
namespace {

static_assert(std::endian::native == std::endian::little, "netlink speaks the machine's own order");

using Bytes = std::vector<std::byte>;

Bytes bytes(std::initializer_list<int> values) {
  Bytes all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

/// Length and type, 16 bits each, what it holds, and zeros up to a multiple of four.
Bytes attribute(int type, const Bytes& holds) {
  const auto length = static_cast<int>(4 + holds.size());
  Bytes all = bytes({length & 255, length >> 8, type & 255, type >> 8});
  all.insert(all.end(), holds.begin(), holds.end());
  while (all.size() % 4 != 0) all.push_back(std::byte{0});
  return all;
}

Bytes operator+(Bytes left, const Bytes& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

constexpr int kNewLink = 16;
constexpr int kName = 3, kLinkInfo = 18, kKind = 1, kData = 2, kBitTiming = 1, kLimits = 2, kClock = 3,
              kState = 4, kRestart = 6, kOnly = 13, kMost = 15, kNested = 0x8000;

/// nlmsghdr, ifinfomsg of zeros, attributes.
Bytes message(int type, const Bytes& attributes) {
  const auto length = static_cast<int>(16 + 16 + attributes.size());
  Bytes all = bytes({length & 255, length >> 8, 0, 0, type, 0, 0, 0});
  all.resize(16 + 16);
  return all + attributes;
}

/// can_bittiming: bitrate, and seven others.
Bytes timing(int bit_rate) {
  Bytes all = bytes({bit_rate & 255, bit_rate >> 8 & 255, bit_rate >> 16 & 255, 0});
  all.resize(32, std::byte{0x7F});
  return all;
}

const Bytes kCan = bytes({'c', 'a', 'n', 0});
const Bytes kNameOfCan0 = attribute(kName, bytes({'c', 'a', 'n', '0', 0}));

Bytes link_of(const Bytes& kind, const Bytes& data) {
  return message(kNewLink,
                 kNameOfCan0 + attribute(kLinkInfo | kNested,
                                         attribute(kKind, kind) + attribute(kData | kNested, data)));
}

TEST(CanBitRate, IsFoundInTheKernelsAnswer) {
  for (const int bit_rate : {10'000, 125'000, 1'000'000}) {
    const Bytes answer =
        link_of(kCan, attribute(kState, bytes({0, 0, 0, 0})) + attribute(kBitTiming, timing(bit_rate)));
    EXPECT_EQ(interface_in(answer).bit_rate, static_cast<std::uint32_t>(bit_rate));
    EXPECT_TRUE(interface_in(answer).controller);
    EXPECT_FALSE(interface_in(answer).up);
    Bytes up = answer;
    up.at(16 + 8) = std::byte{0x41};  // ifi_flags: IFF_UP, IFF_RUNNING
    EXPECT_TRUE(interface_in(up).up);
  }
}

TEST(CanBitRate, IsNoneOfAnInterfaceOfAnotherKindOrBeforeOneWasSet) {
  const CanInterface virtual_one =
      interface_in(link_of(bytes({'v', 'c', 'a', 'n', 0}), attribute(kBitTiming, timing(1))));
  EXPECT_EQ(virtual_one.bit_rate, std::nullopt);
  EXPECT_FALSE(virtual_one.controller);
  const CanInterface fresh = interface_in(link_of(kCan, attribute(kState, bytes({0, 0, 0, 0}))));
  EXPECT_EQ(fresh.bit_rate, std::nullopt);
  EXPECT_TRUE(fresh.controller);
  for (const Bytes& other : {message(kNewLink, kNameOfCan0), message(2, {})}) {  // 2: an error, NLMSG_ERROR
    EXPECT_EQ(interface_in(other).bit_rate, std::nullopt);
    EXPECT_FALSE(interface_in(other).controller);
  }
}

TEST(CanBitRate, OfAnAnswerThatIsCutShortNothingIsReadBeyondItsEnd) {
  const Bytes whole = link_of(kCan, attribute(kBitTiming, timing(500'000)));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    // of its own size, so that a memory checker sees each byte beyond
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(interface_in(cut).bit_rate, std::nullopt) << size << " bytes";
    Bytes consistent = cut;  // its header says so, too
    if (size < 32) continue;
    consistent[0] = static_cast<std::byte>(size);
    EXPECT_EQ(interface_in(consistent).bit_rate, std::nullopt) << size << " bytes";
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int value : {0, 1, 3, 255}) {
      Bytes upset = whole;
      upset[at] = static_cast<std::byte>(value);
      interface_in(upset);  // ends, within its bytes
    }
  }
}

/// The request that sets one attribute of controller 7.
Bytes request(int type, const Bytes& holds) {
  Bytes all = message(
      kNewLink, attribute(kLinkInfo, attribute(kKind, kCan) + attribute(kData, attribute(type, holds))));
  all.at(6) = std::byte{1 | 4};   // NLM_F_REQUEST, NLM_F_ACK
  all.at(16 + 4) = std::byte{7};  // ifi_index
  return all;
}

TEST(CanBitRate, IsAskedForInTheAttributesInWhichTheKernelTellsIt) {
  Bytes timing = bytes({0x20, 0xA1, 0x07, 0});  // 500,000
  timing.resize(32, std::byte{0});              // the rest is the kernel's to work out
  EXPECT_EQ(bit_rate_request(7, 500'000), request(kBitTiming, timing));
  EXPECT_EQ(restart_request(7, 100), request(kRestart, bytes({100, 0, 0, 0})));
}

Bytes words(std::initializer_list<int> values) {
  Bytes all;
  for (const int value : values)
    all = all + bytes({value & 255, value >> 8 & 255, value >> 16 & 255, value >> 24});
  return all;
}

TEST(CanBitRate, OnesThatAControllerCanRunAtAreThoseThatItsClockGives) {
  // can_bittiming_const: a name of 16 characters, then tseg1, tseg2, sjw, brp as the kernel's drivers state them.
  const Bytes name(16, std::byte{'x'});
  const Bytes sja1000 = name + words({1, 16, 1, 8, 4, 1, 64, 1}),
              mcp251x = name + words({3, 16, 2, 8, 4, 1, 64, 1});
  const auto controller = [](const Bytes& limits, int clock_Hz) {
    return interface_in(link_of(kCan, attribute(kLimits, limits) + attribute(kClock, words({clock_Hz}))));
  };
  for (const std::uint32_t kbit : {1000U, 800U, 500U, 250U, 125U, 50U, 20U, 10U})
    EXPECT_TRUE(controller(sja1000, 8'000'000).can_run_at(1000 * kbit)) << kbit;
  EXPECT_TRUE(controller(sja1000, 8'000'000).can_run_at(5'000)) << "64 periods a quantum, 1 + 16 + 8 of them";
  EXPECT_FALSE(controller(sja1000, 8'000'000).can_run_at(4'000)) << "slower than that";
  EXPECT_FALSE(controller(sja1000, 8'000'000).can_run_at(4'000'000)) << "faster than three quanta";
  // An MCP2515 with a crystal of 8 MHz, of which it makes 4: known for not reaching 1 Mbit/s.
  EXPECT_FALSE(controller(mcp251x, 4'000'000).can_run_at(1'000'000));
  EXPECT_FALSE(controller(mcp251x, 4'000'000).can_run_at(800'000));
  EXPECT_TRUE(controller(mcp251x, 4'000'000).can_run_at(500'000));
  // 37.5 periods a bit: 789,474 or 810,811 bit/s, which the kernel would take.
  EXPECT_FALSE(controller(name + words({1, 64, 1, 32, 16, 1, 512, 1}), 30'000'000).can_run_at(800'000));
  EXPECT_TRUE(controller(name + words({1, 64, 1, 32, 16, 1, 512, 1}), 30'000'000).can_run_at(1'000'000));
}

TEST(CanBitRate, OnesThatADriverOrATransceiverStatesAreTakenAsTheyAre) {
  const CanInterface listed = interface_in(link_of(kCan, attribute(kOnly, words({125'000, 500'000}))));
  EXPECT_TRUE(listed.can_run_at(500'000));
  EXPECT_FALSE(listed.can_run_at(250'000));
  const CanInterface slow = interface_in(link_of(kCan, attribute(kMost, words({500'000}))));
  EXPECT_TRUE(slow.can_run_at(500'000));
  EXPECT_FALSE(slow.can_run_at(800'000));
  EXPECT_TRUE(interface_in(link_of(kCan, {})).can_run_at(10'000)) << "nothing is stated";
  EXPECT_FALSE(interface_in(link_of(kCan, {})).can_run_at(0));
}

TEST(CanBitRate, ThisMachinesKernelAnswers) {
  const auto loopback = can_interface("lo");
  ASSERT_TRUE(loopback);
  EXPECT_TRUE(loopback->up);
  EXPECT_FALSE(loopback->controller);
  EXPECT_EQ(loopback->bit_rate, std::nullopt);
  EXPECT_FALSE(can_interface("plenum-none"));
}

}  // namespace
}  // namespace plenum::board::drivers
