#include "host-sim/wire/socketcand.hpp"

#include <gtest/gtest.h>

#include "host-sim/wire/time_stamp.hpp"

namespace plenum::host::wire {
namespace {

CanFrame frame_of(std::uint32_t id, std::vector<std::uint8_t> bytes, bool extended = false) {
  CanFrame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size()), .extended = extended};
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

std::optional<CanFrame> frame_in(std::string_view message) {
  return parse_frame(words_of(message));
}
std::optional<CanFrame> sent_in(std::string_view message) {
  return parse_send(words_of(message));
}

// The examples of the protocol's own page.

TEST(SocketcandMessage, SaysFramesAsTheProtocolsPageDoes) {
  EXPECT_EQ(frame_message(frame_of(0x123, {0x1A, 0x22, 0x03, 0x44}), 23'424'242),
            "< frame 123 23.424242 1A220344 >");
  EXPECT_EQ(send_message(frame_of(0x123, {})), "< send 123 0 >");
  EXPECT_EQ(send_message(frame_of(0x1AAAAAAA, {0x01, 0xF1}, true)), "< send 1AAAAAAA 2 1 f1 >");
}

TEST(SocketcandMessage, ReadsFramesAsTheProtocolsPageSaysThem) {
  EXPECT_EQ(frame_in("< frame 123 23.424242 1A220344 >"), frame_of(0x123, {0x1A, 0x22, 0x03, 0x44}));
  EXPECT_EQ(sent_in("< send 123 0 >"), frame_of(0x123, {}));
  EXPECT_EQ(sent_in("< send 1AAAAAAA 2 1 f1 >"), frame_of(0x1AAAAAAA, {0x01, 0xF1}, true));
}

TEST(SocketcandMessage, AFrameWithoutDataKeepsTheSpaceOfItsBytes) {
  EXPECT_EQ(frame_message(frame_of(0x80, {}), 5), "< frame 080 0.000005  >");
  EXPECT_EQ(frame_in("< frame 080 0.000005  >"), frame_of(0x80, {}));
}

TEST(SocketcandMessage, TheBroadcastManagersSpacedBytesAreReadToo) {
  EXPECT_EQ(frame_in("< frame 181 1.0 01 AB  >"), frame_of(0x181, {0x01, 0xAB}));
}

TEST(SocketcandMessage, EightDigitsAreA29BitIdentifier) {
  EXPECT_EQ(frame_message(frame_of(0x12, {1}, true), 0), "< frame 00000012 0.000000 01 >");
  EXPECT_EQ(frame_in("< frame 00000012 0.0 01 >"), frame_of(0x12, {1}, true));
  EXPECT_EQ(sent_in("< send 012 1 1 >"), frame_of(0x12, {1}));
}

TEST(SocketcandMessage, AnIdentifierThatElevenBitsCannotHoldIsA29BitOne) {
  EXPECT_EQ(sent_in("< send 800 0 >"), frame_of(0x800, {}, true));
  EXPECT_EQ(sent_in("< send 7FF 0 >"), frame_of(0x7FF, {}));
}

TEST(SocketcandMessage, WhatIsNoFrameIsNone) {
  for (const char* text : {"< send >", "< send 123 >", "< send 123 1 >", "< send 123 1 1 2 >",
                           "< send 123 9 1 2 3 4 5 6 7 8 9 >", "< send 20000000 0 >", "< send 012345678 0 >",
                           "< send 123 1 100 >", "< send 123 1 -1 >", "< send x 0 >", "< send 123 1 1g >",
                           "< sendpdu 123 0 >", "< >", ""}) {
    EXPECT_FALSE(sent_in(text)) << text;
  }
  for (const char* text :
       {"< frame 123 >", "< frame 123 1.0 1 >", "< frame 123 1.0 112233445566778899 >",
        "< frame 123 1.0 0G >", "< frame FFFFFFFF 1.0 00 >", "< error 004 1.0 >", "< ok >"}) {
    EXPECT_FALSE(frame_in(text)) << text;
  }
}

TEST(TimeStamp, IsSecondsWithSixDecimals) {
  EXPECT_EQ(parse_stamp_us("23.424242"), 23'424'242U);
  EXPECT_EQ(parse_stamp_us("1700000000.000001"), 1'700'000'000'000'001U);
  for (const char* text : {"23", "23.", "23.4", "23.4242421", ".424242", "23,424242", "-1.424242",
                           "23.-42424", "99999999999999.000000"})
    EXPECT_EQ(parse_stamp_us(text), std::nullopt) << text;
}

std::vector<std::string> all(MessageReader& reader) {
  std::vector<std::string> messages;
  while (auto message = reader.next()) messages.push_back(*message);
  return messages;
}

TEST(SocketcandReader, MessagesAreTheSameHoweverTheBytesAreCut) {
  const std::string bytes = "< hi >< ok >\r\n < frame 123 1.0 01 >";
  const std::vector<std::string> messages{"< hi >", "< ok >", "< frame 123 1.0 01 >"};
  for (std::size_t first = 0; first <= bytes.size(); ++first) {
    for (std::size_t second = first; second <= bytes.size(); ++second) {
      MessageReader reader;
      std::vector<std::string> found;
      for (const std::string& piece :
           {bytes.substr(0, first), bytes.substr(first, second - first), bytes.substr(second)}) {
        ASSERT_TRUE(reader.append(piece));
        for (std::string& message : all(reader)) found.push_back(std::move(message));
      }
      ASSERT_EQ(found, messages) << first << ' ' << second;
    }
  }
}

TEST(SocketcandReader, WhatStandsBetweenMessagesIsPassedOver) {
  MessageReader reader;
  ASSERT_TRUE(reader.append("noise >> < half < whole >tail"));
  EXPECT_EQ(all(reader), std::vector<std::string>{"< whole >"});
}

TEST(SocketcandReader, AStreamWithoutMessagesIsRefusedBeforeItGrows) {
  MessageReader reader;
  EXPECT_TRUE(reader.append(std::string(MessageReader::kLongest, 'x')));
  EXPECT_FALSE(reader.append("x"));
}

}  // namespace
}  // namespace plenum::host::wire
