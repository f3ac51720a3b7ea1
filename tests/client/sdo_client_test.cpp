// Block transfers against frames written by hand from CiA 301, 7.2.4.3.9 to 7.2.4.3.16, and against a small server of
// the tests' own behind a link that loses, doubles or delays each frame in turn.
#include "host-sim/client/sdo_client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "tests/client/faulty_link.hpp"
#include "tests/client/scripted_link.hpp"

namespace plenum::host::client {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using Frames = std::vector<std::string>;
using Bytes = std::vector<std::uint8_t>;

Bytes counted(std::size_t size) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
  return bytes;
}

SdoClient client_on(Link& link, const SdoConfig& config = {}) {
  return {link, 5, config, {}};
}

TEST(Crc16, HasTheCheckValueOfTheStandard) {
  const std::string text = "123456789";
  EXPECT_EQ(crc16(Bytes(text.begin(), text.end())), 0x31C3);
  EXPECT_EQ(crc16({}), 0);
}

// ---- writing, frames by hand: 17 bytes are 3 segments, of the last one 4 bytes are unused, CRC DB13h ----

const SdoConfig kBlocksOf17{.block_from_bytes = 17};

TEST(SdoBlockDownload, SendsBlocksOfTheServersSizeAndEndsWithTheCrc) {
  ScriptedLink link({"585 A4 10 21 00 02 00 00 00", "", "585 A2 02 7F 00 00 00 00 00",
                     "585 A2 01 7F 00 00 00 00 00", "585 A1 00 00 00 00 00 00 00"});
  std::vector<std::pair<std::size_t, std::optional<std::size_t>>> progress;
  client_on(link, kBlocksOf17)
      .write(0x2110, 0, counted(17),
             [&](std::size_t done, std::optional<std::size_t> total) { progress.emplace_back(done, total); });
  EXPECT_EQ(link.sent, (Frames{"605 C6 10 21 00 11 00 00 00", "605 01 01 02 03 04 05 06 07",
                               "605 02 08 09 0A 0B 0C 0D 0E", "605 81 0F 10 11 00 00 00 00",
                               "605 D1 13 DB 00 00 00 00 00"}));
  EXPECT_EQ(progress, (decltype(progress){{14, 17}, {17, 17}}));
}

TEST(SdoBlockDownload, SendsNoCrcToAServerWithoutOne) {
  ScriptedLink link(
      {"585 A0 10 21 00 7F 00 00 00", "", "", "585 A2 03 7F 00 00 00 00 00", "585 A1 00 00 00 00 00 00 00"});
  client_on(link, kBlocksOf17).write(0x2110, 0, counted(17));
  EXPECT_EQ(link.sent.back(), "605 D1 00 00 00 00 00 00 00");
}

TEST(SdoBlockDownload, SendsAgainFromTheSegmentThatWasLostOnInBlocksOfTheNewSize) {
  ScriptedLink link({"585 A4 10 21 00 7F 00 00 00", "", "", "585 A2 01 01 00 00 00 00 00",
                     "585 A2 01 01 00 00 00 00 00", "585 A2 01 01 00 00 00 00 00",
                     "585 A1 00 00 00 00 00 00 00"});
  client_on(link, kBlocksOf17).write(0x2110, 0, counted(17));
  EXPECT_EQ(link.sent, (Frames{"605 C6 10 21 00 11 00 00 00", "605 01 01 02 03 04 05 06 07",
                               "605 02 08 09 0A 0B 0C 0D 0E", "605 83 0F 10 11 00 00 00 00",
                               "605 01 08 09 0A 0B 0C 0D 0E", "605 81 0F 10 11 00 00 00 00",
                               "605 D1 13 DB 00 00 00 00 00"}));
}

TEST(SdoBlockDownload, StopsSendingWhenTheServerAborts) {
  ScriptedLink link({"585 A4 10 21 00 7F 00 00 00", "585 80 10 21 00 20 00 00 08"});
  EXPECT_THROW(client_on(link, kBlocksOf17).write(0x2110, 0, counted(17)), SdoAbort);
  EXPECT_EQ(link.sent.size(), 2U);
}

TEST(SdoBlockDownload, FallsBackToSegmentsForAServerThatKnowsNoBlocksAndDoesNotAskAgain) {
  ScriptedLink link(
      {"585 80 10 21 00 01 00 04 05", "585 60 10 21 00 00 00 00 00", "585 20 00 00 00 00 00 00 00",
       "585 30 00 00 00 00 00 00 00", "585 20 00 00 00 00 00 00 00", "585 60 10 21 00 00 00 00 00",
       "585 20 00 00 00 00 00 00 00", "585 30 00 00 00 00 00 00 00", "585 20 00 00 00 00 00 00 00",
       "585 41 18 21 00 04 00 00 00", "585 07 01 02 03 04 00 00 00"});
  SdoClient client = client_on(link, kBlocksOf17);
  client.write(0x2110, 0, counted(17));
  client.write(0x2110, 0, counted(17));
  EXPECT_EQ(client.read_domain(0x2118, 0), counted(4));
  EXPECT_EQ(link.sent[0], "605 C6 10 21 00 11 00 00 00");
  EXPECT_EQ(link.sent[1], "605 21 10 21 00 11 00 00 00");
  EXPECT_EQ(link.sent[5], "605 21 10 21 00 11 00 00 00");
  EXPECT_EQ(link.sent[9], "605 40 18 21 00 00 00 00 00");
}

TEST(SdoBlockDownload, GivesUpOnAnswersThatCannotBe) {
  struct Case {
    std::deque<std::string> script;
    const char* abort;
  };
  const std::vector<Case> cases{
      {{"585 A4 10 21 00 00 00 00 00"}, "605 80 10 21 00 02 00 04 05"},  // block size 0
      {{"585 A4 10 21 00 80 00 00 00"}, "605 80 10 21 00 02 00 04 05"},  // and 128
      {{"585 60 10 21 00 7F 00 00 00"}, "605 80 10 21 00 01 00 04 05"},  // of segments
      {{"585 A4 10 21 00 7F 00 00 00", "", "", "585 A2 04 7F 00 00 00 00 00"}, "605 80 10 21 00 03 00 04 05"},
      {{"585 A4 10 21 00 7F 00 00 00", "", "", "585 C1 00 00 00 00 00 00 00"}, "605 80 10 21 00 01 00 04 05"},
  };
  for (const Case& one : cases) {
    ScriptedLink link(one.script);
    EXPECT_THROW(client_on(link, kBlocksOf17).write(0x2110, 0, counted(17)), ProtocolError)
        << one.script.back();
    EXPECT_EQ(link.sent.back(), one.abort);
  }
  ScriptedLink deaf({"585 A4 10 21 00 01 00 00 00", "585 A2 00 01 00 00 00 00 00",
                     "585 A2 00 01 00 00 00 00 00", "585 A2 00 01 00 00 00 00 00",
                     "585 A2 00 01 00 00 00 00 00"});
  EXPECT_THROW(client_on(deaf, kBlocksOf17).write(0x2110, 0, counted(17)), ProtocolError);
  EXPECT_EQ(deaf.sent.size(), 5U) << "request, three tries, abort";
}

// ---- a server that is silent ----

std::string time_out_of(std::deque<std::string> script, const SdoConfig& config) {
  ScriptedLink link(std::move(script));
  try {
    client_on(link, config).read(0x1000, 0);
  } catch (const Timeout& error) {
    return error.what();
  }
  return "no time-out";
}

TEST(SdoTimeOut, TellsWhatTheHeartbeatSaysOfTheSilence) {
  const SdoConfig patient{.heartbeat_wait_s = 2.5};
  // the heartbeat comes after the abort that gives the request up
  EXPECT_THAT(
      time_out_of({"", "706 04|705 04"}, patient),
      EndsWith(
          "expected one on 585h; its heartbeat says that it is stopped, a state in which no node answers: "
          "plenum nmt --pre-operational ends it"));
  EXPECT_THAT(time_out_of({"705 05"}, patient), EndsWith("; its heartbeat says that it is operational"));
  EXPECT_THAT(time_out_of({"706 04"}, patient), EndsWith("; no heartbeat came within 2.5 s either"));
  EXPECT_THAT(time_out_of({""}, {}), EndsWith("expected one on 585h")) << "who does not listen says nothing";
  EXPECT_THAT(time_out_of({"", "605 40 01 10 00 00 00 00 00"}, patient),
              EndsWith("; no heartbeat came within 2.5 s either"))
      << "what another asks for then disturbs nothing";
}

// ---- reading, frames by hand ----

TEST(SdoBlockUpload, TakesBlocksAcknowledgesThemAndChecksTheCrc) {
  ScriptedLink link({"585 C6 18 21 00 11 00 00 00", "585 01 01 02 03 04 05 06 07|585 02 08 09 0A 0B 0C 0D 0E",
                     "585 81 0F 10 11 00 00 00 00", "585 D1 13 DB 00 00 00 00 00"});
  std::vector<std::pair<std::size_t, std::optional<std::size_t>>> progress;
  const Bytes bytes = client_on(link, {.block_from_bytes = 17, .block_size = 2})
                          .read_domain(0x2118, 0, [&](std::size_t done, std::optional<std::size_t> total) {
                            progress.emplace_back(done, total);
                          });
  EXPECT_EQ(bytes, counted(17));
  EXPECT_EQ(link.sent, (Frames{"605 A4 18 21 00 02 10 00 00", "605 A3 00 00 00 00 00 00 00",
                               "605 A2 02 02 00 00 00 00 00", "605 A2 01 02 00 00 00 00 00",
                               "605 A1 00 00 00 00 00 00 00"}));
  EXPECT_EQ(progress, (decltype(progress){{14, 17}, {17, 17}}));
}

TEST(SdoBlockUpload, TakesAValueWhoseSizeTheServerDoesNotKnow) {
  ScriptedLink link({"585 C4 18 21 00 00 00 00 00",
                     "585 01 01 02 03 04 05 06 07|585 02 08 09 0A 0B 0C 0D 0E|585 83 0F 10 11 00 00 00 00",
                     "585 D1 13 DB 00 00 00 00 00"});
  bool total_known = true;
  EXPECT_EQ(client_on(link).read_domain(0x2118, 0,
                                        [&](std::size_t, auto total) { total_known = total.has_value(); }),
            counted(17));
  EXPECT_FALSE(total_known);
}

TEST(SdoBlockUpload, LetsTheServerSwitchToSegmentsOrExpedited) {
  ScriptedLink segments({"585 41 18 21 00 05 00 00 00", "585 05 01 02 03 04 05 00 00"});
  EXPECT_EQ(client_on(segments).read_domain(0x2118, 0), counted(5));
  ScriptedLink expedited({"585 43 18 21 00 01 02 03 04"});
  EXPECT_EQ(client_on(expedited).read_domain(0x2118, 0), counted(4));
}

TEST(SdoBlockUpload, AsksAgainFromTheSegmentThatWasLost) {
  ScriptedLink link({"585 C6 18 21 00 11 00 00 00",
                     "585 01 01 02 03 04 05 06 07|585 83 0F 10 11 00 00 00 00",  // the second is missing
                     "585 01 08 09 0A 0B 0C 0D 0E|585 82 0F 10 11 00 00 00 00",
                     "585 D1 13 DB 00 00 00 00 00"});
  EXPECT_EQ(client_on(link).read_domain(0x2118, 0), counted(17));
  EXPECT_EQ(link.sent[2], "605 A2 01 7F 00 00 00 00 00");
  EXPECT_EQ(link.sent[3], "605 A2 02 7F 00 00 00 00 00");
}

TEST(SdoBlockUpload, GivesUpOnBytesThatAreNotThoseAnnounced) {
  struct Case {
    std::deque<std::string> script;
    const char* abort;
  };
  const std::string whole =
      "585 01 01 02 03 04 05 06 07|585 02 08 09 0A 0B 0C 0D 0E|585 83 0F 10 11 00 00 00 00";
  const std::vector<Case> cases{
      {{"585 C6 18 21 00 11 00 00 00", whole, "585 D1 14 DB 00 00 00 00 00"},
       "605 80 18 21 00 04 00 04 05"},  // CRC
      {{"585 C6 18 21 00 10 00 00 00", whole, "585 D1 13 DB 00 00 00 00 00"}, "605 80 18 21 00 10 00 07 06"},
      {{"585 C6 18 21 00 07 00 00 00", whole}, "605 80 18 21 00 10 00 07 06"},  // goes on beyond its size
      {{"585 C6 18 21 00 11 00 00 00", "585 00 01 02 03 04 05 06 07"}, "605 80 18 21 00 03 00 04 05"},
      {{"585 60 18 21 00 00 00 00 00"}, "605 80 18 21 00 01 00 04 05"},
  };
  for (const Case& one : cases) {
    ScriptedLink link(one.script);
    EXPECT_THROW(client_on(link).read_domain(0x2118, 0), ProtocolError) << one.script.front();
    EXPECT_EQ(link.sent.back(), one.abort);
  }
  ScriptedLink endless({"585 C4 18 21 00 00 00 00 00", whole});
  EXPECT_THROW(client_on(endless, {.largest_bytes = 7}).read_domain(0x2118, 0), ProtocolError);
}

std::string repeated(const std::string& frame, int times) {
  std::string line = frame;
  while (--times > 0) line += '|' + frame;
  return line;
}

TEST(SdoBlockUpload, GivesUpOnAServerThatRepeatsAFrameForEver) {
  const std::string first = "585 C6 18 21 00 11 00 00 00";
  const std::string segment = "585 01 01 02 03 04 05 06 07";
  const std::string second = "585 02 08 09 0A 0B 0C 0D 0E";
  const std::string last = "585 83 0F 10 11 00 00 00 00";
  constexpr int kForEver = 1000;
  for (const std::deque<std::string>& script : std::vector<std::deque<std::string>>{
           {first, repeated(segment, kForEver)},
           {first, segment + '|' + second + '|' + repeated(segment, kForEver)},
           {first, segment + '|' + second + '|' + last, repeated(last, kForEver)}}) {
    ScriptedLink link(script);
    EXPECT_THROW(client_on(link).read_domain(0x2118, 0), ProtocolError) << script.back().substr(0, 27);
    EXPECT_EQ(link.sent.back(), "605 80 18 21 00 03 00 04 05");
  }
}

TEST(SdoUpload, GivesUpOnAServerWhoseSegmentsAreEmpty) {
  ScriptedLink link(
      {"585 41 18 21 00 11 00 00 00", "585 0E 00 00 00 00 00 00 00", "585 1E 00 00 00 00 00 00 00"});
  EXPECT_THROW(client_on(link).read(0x2118, 0), ProtocolError);
  EXPECT_EQ(link.sent.back(), "605 80 18 21 00 00 00 00 08");
}

TEST(SdoUpload, TakesAnEmptyValue) {
  ScriptedLink link({"585 40 18 21 00 00 00 00 00", "585 0F 00 00 00 00 00 00 00"});
  EXPECT_EQ(client_on(link).read(0x2118, 0), Bytes{});
}

TEST(SdoBlockUpload, ThrowsTheAbortOfTheServerInTheMiddle) {
  ScriptedLink link(
      {"585 C6 18 21 00 11 00 00 00", "585 01 01 02 03 04 05 06 07|585 80 18 21 00 20 00 00 08"});
  EXPECT_THROW(client_on(link).read_domain(0x2118, 0), SdoAbort);
}

// ---- each frame lost, doubled, late: right bytes or a clear error, soon, and the next transfer works ----

struct Outcome {
  bool done = false;
  double took_s = 0.0;
  std::string error;
};

template <class Transfer>
Outcome outcome_of(FaultyLink& link, const Transfer& transfer) {
  Outcome outcome;
  const double from_s = link.now_s();
  try {
    transfer();
    outcome.done = true;
  } catch (const SdoAbort& error) {
    outcome.error = error.what();
  } catch (const Timeout& error) {
    outcome.error = error.what();
  } catch (const ProtocolError& error) {
    outcome.error = error.what();
  }
  outcome.took_s = link.now_s() - from_s;
  return outcome;
}

class SdoOnAFaultyLink : public ::testing::TestWithParam<std::tuple<LinkFault, bool>> {
 protected:
  static constexpr std::size_t kSize = 101;  // 15 segments, the last of 3 bytes
  static constexpr double kPatience_s = 4.0;
  bool harmless_to(const FaultyLink& link) const {
    return fault_ == LinkFault::none || (fault_ == LinkFault::doubled && link.spoilt_for_the_client_alone());
  }
  LinkFault fault_ = std::get<0>(GetParam());
  bool option_ = std::get<1>(GetParam());
};

TEST_P(SdoOnAFaultyLink, ReadsRightOrSaysWhyNot) {
  int completed = 0;
  std::size_t frames = 1;
  for (std::size_t number = 0; number < frames; ++number) {
    FaultyLink link;
    link.server.value = counted(kSize);
    link.server.tells_size = option_;
    SdoClient client = client_on(link, {.block_size = 5});
    link.spoil(number, fault_);
    Bytes bytes;
    const Outcome outcome = outcome_of(link, [&] { bytes = client.read_domain(0x2118, 0); });
    frames = std::max(frames, link.frames());
    EXPECT_LT(outcome.took_s, kPatience_s) << "frame " << number;
    if (outcome.done) {
      EXPECT_EQ(bytes, counted(kSize)) << "frame " << number;
      ++completed;
    } else {
      EXPECT_THAT(outcome.error, HasSubstr("node 5: reading 2118h:0")) << "frame " << number;
    }
    EXPECT_TRUE(outcome.done || !harmless_to(link)) << "frame " << number << ": " << outcome.error;
    link.spoil(0, LinkFault::none);
    while (link.receive(2.0)) {
      // what was late arrives
    }
    EXPECT_EQ(client.read_domain(0x2118, 0), counted(kSize)) << "after a fault of frame " << number;
  }
  if (fault_ == LinkFault::lost) {
    EXPECT_EQ(completed, static_cast<int>(frames) - 4)
        << "all but the request, its answer, the start and the end";
  }
}

TEST_P(SdoOnAFaultyLink, WritesRightOrSaysWhyNot) {
  std::size_t frames = 1;
  for (std::size_t number = 0; number < frames; ++number) {
    FaultyLink link;
    link.server.acknowledges_after_silence = option_;
    SdoClient client = client_on(link);
    link.spoil(number, fault_);
    const Outcome outcome = outcome_of(link, [&] { client.write(0x2110, 0, counted(kSize)); });
    frames = std::max(frames, link.frames());
    EXPECT_LT(outcome.took_s, kPatience_s) << "frame " << number;
    if (outcome.done) {
      EXPECT_EQ(link.server.value, counted(kSize)) << "frame " << number;
    } else {
      EXPECT_THAT(outcome.error, HasSubstr("node 5: writing 2110h:0")) << "frame " << number;
      EXPECT_TRUE(link.server.value.empty() || link.server.value == counted(kSize)) << "frame " << number;
    }
    EXPECT_TRUE(outcome.done || !harmless_to(link)) << "frame " << number << ": " << outcome.error;
    link.spoil(0, LinkFault::none);
    while (link.receive(2.0)) {
      // what was late arrives
    }
    client.write(0x2110, 0, counted(70));
    EXPECT_EQ(link.server.value, counted(70)) << "after a fault of frame " << number;
  }
}

INSTANTIATE_TEST_SUITE_P(EachFrame, SdoOnAFaultyLink,
                         ::testing::Combine(::testing::Values(LinkFault::none, LinkFault::lost,
                                                              LinkFault::doubled, LinkFault::overtaken,
                                                              LinkFault::late),
                                            ::testing::Bool()));

}  // namespace
}  // namespace plenum::host::client
