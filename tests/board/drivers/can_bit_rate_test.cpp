// The kernel's answer to RTM_GETLINK, its bytes written by hand after rtnetlink(7) and linux/can/netlink.h; and a question to this
// machine's kernel about an interface that is no CAN.
#include "board/drivers/can_bit_rate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <initializer_list>
#include <stdexcept>
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
constexpr int kName = 3, kLinkInfo = 18, kKind = 1, kData = 2, kBitTiming = 1, kState = 4, kNested = 0x8000;

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
    EXPECT_EQ(bit_rate_in(answer), static_cast<std::uint32_t>(bit_rate));
  }
}

TEST(CanBitRate, IsNoneOfAnInterfaceOfAnotherKindOrWithoutTiming) {
  EXPECT_EQ(bit_rate_in(link_of(bytes({'v', 'c', 'a', 'n', 0}), attribute(kBitTiming, timing(1)))),
            std::nullopt);
  EXPECT_EQ(bit_rate_in(link_of(kCan, attribute(kState, bytes({0, 0, 0, 0})))), std::nullopt);
  EXPECT_EQ(bit_rate_in(message(kNewLink, kNameOfCan0)), std::nullopt);
  EXPECT_EQ(bit_rate_in(message(2, {})), std::nullopt) << "an error, NLMSG_ERROR";
}

TEST(CanBitRate, OfAnAnswerThatIsCutShortNothingIsReadBeyondItsEnd) {
  const Bytes whole = link_of(kCan, attribute(kBitTiming, timing(500'000)));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    // of its own size, so that a memory checker sees each byte beyond
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(bit_rate_in(cut), std::nullopt) << size << " bytes";
    Bytes consistent = cut;  // its header says so, too
    if (size < 32) continue;
    consistent[0] = static_cast<std::byte>(size);
    EXPECT_EQ(bit_rate_in(consistent), std::nullopt) << size << " bytes";
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int value : {0, 1, 3, 255}) {
      Bytes upset = whole;
      upset[at] = static_cast<std::byte>(value);
      bit_rate_in(upset);  // ends, within its bytes
    }
  }
}

TEST(CanBitRate, ThisMachinesKernelAnswers) {
  EXPECT_EQ(can_bit_rate("lo"), std::nullopt);
  try {
    can_bit_rate("plenum-none");
    FAIL() << "no failure";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "can:plenum-none: bit rate: no such interface, expected the kernel's answer");
  }
}

}  // namespace
}  // namespace plenum::board::drivers
