// Block transfers, frame by frame, written from CiA 301 7.2.4.3.9 to 7.2.4.3.16 and not by the code under test. The CRCs
// are those of Python's binascii.crc_hqx.
#include <gtest/gtest.h>

#include <algorithm>

#include "firmware/canopen/crc16.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

std::vector<std::uint8_t> counting(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i + 1);
  return bytes;
}

struct BlockBench : Bench {
  BlockBench() {
    answer("605 2B 17 10 00 00 00 00 00");  // no heartbeat in between
    tick();
    drain();
  }
};

TEST(Crc16, IsThatOfCia301) {
  constexpr std::array<std::uint8_t, 9> kDigits = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc16(kDigits), 0x31C3);
  EXPECT_EQ(crc16(std::span(kDigits).subspan<4>(), crc16(std::span(kDigits).first<4>())), 0x31C3);
}

// ---- download ----

constexpr const char* kOpenTen = "605 C6 10 21 00 0A 00 00 00";  // 2110h, 10 bytes, CRC
constexpr const char* kFirst = "605 01 01 02 03 04 05 06 07";
constexpr const char* kSecondLast = "605 82 08 09 0A 00 00 00 00";
constexpr const char* kEndTen = "605 D1 4B CD 00 00 00 00 00";  // 4 bytes unused, CRC CD4Bh
constexpr const char* kDone = "585 A1 00 00 00 00 00 00 00";

TEST(BlockDownload, TakesTenBytesInTwoSegments) {
  BlockBench bench;
  EXPECT_EQ(bench.answer(kOpenTen), "585 A4 10 21 00 7F 00 00 00");
  EXPECT_EQ(bench.answer(kFirst), "");
  EXPECT_EQ(bench.answer(kSecondLast), "585 A2 02 7F 00 00 00 00 00");
  EXPECT_EQ(bench.desk.hand_ins, 0) << "nothing is handed in before the end request";
  EXPECT_EQ(bench.answer_in_tick(kEndTen), kDone);
  EXPECT_EQ(bench.desk.staged[0], counting(10));
  EXPECT_EQ(bench.desk.hand_ins, 1);
}

TEST(BlockDownload, NeedsNeitherSizeNorCrc) {
  BlockBench bench;
  EXPECT_EQ(bench.answer("605 C0 10 21 00 00 00 00 00"), "585 A4 10 21 00 7F 00 00 00");
  bench.answer(kFirst);
  bench.answer(kSecondLast);
  EXPECT_EQ(bench.answer_in_tick("605 D1 00 00 00 00 00 00 00"), kDone);
  EXPECT_EQ(bench.desk.staged[0], counting(10));
}

TEST(BlockDownload, WritesAScalarToo) {
  BlockBench bench;
  EXPECT_EQ(bench.answer("605 C6 17 10 00 02 00 00 00"), "585 A4 17 10 00 7F 00 00 00");
  EXPECT_EQ(bench.answer("605 81 2C 01 00 00 00 00 00"), "585 A2 01 7F 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 D5 AA 53 00 00 00 00 00"), kDone);
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 2C 01 00 00");
}

TEST(BlockDownload, TakesALostSegmentWhenItComesAgain) {
  BlockBench bench;
  bench.answer("605 C6 10 21 00 19 00 00 00");  // 25 bytes
  EXPECT_EQ(bench.answer(kFirst), "");
  // segment 2 is lost
  EXPECT_EQ(bench.answer("605 03 0F 10 11 12 13 14 15"), "");
  EXPECT_EQ(bench.answer("605 84 16 17 18 19 00 00 00"), "585 A2 01 7F 00 00 00 00 00") << "only the first";
  EXPECT_EQ(bench.answer("605 01 08 09 0A 0B 0C 0D 0E"), "");
  EXPECT_EQ(bench.answer("605 02 0F 10 11 12 13 14 15"), "");
  EXPECT_EQ(bench.answer("605 83 16 17 18 19 00 00 00"), "585 A2 03 7F 00 00 00 00 00");
  EXPECT_EQ(bench.answer_in_tick("605 CD 7F 9A 00 00 00 00 00"), kDone);
  EXPECT_EQ(bench.desk.staged[0], counting(25));
}

TEST(BlockDownload, LeavesDuplicatesAndSegmentsOutOfOrderAlone) {
  BlockBench bench;
  bench.answer(kOpenTen);
  EXPECT_EQ(bench.answer("605 03 EE EE EE EE EE EE EE"), "");
  EXPECT_EQ(bench.answer(kFirst), "");
  EXPECT_EQ(bench.answer(kFirst), "");
  EXPECT_EQ(bench.answer(kSecondLast), "585 A2 02 7F 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kSecondLast), "") << "82h would read as an abort";
  EXPECT_EQ(bench.answer_in_tick(kEndTen), kDone);
  EXPECT_EQ(bench.desk.staged[0], counting(10));
}

TEST(BlockDownload, LeavesItsFirstAndItsLastRequestAloneWhenTheyComeTwice) {
  BlockBench bench;
  bench.answer(kOpenTen);
  EXPECT_EQ(bench.answer(kOpenTen), "") << "no segment 46h";
  EXPECT_EQ(bench.answer(kFirst), "");
  EXPECT_EQ(bench.answer(kSecondLast), "585 A2 02 7F 00 00 00 00 00");
  EXPECT_EQ(bench.answer(kEndTen), "") << "it is answered in the next tick";
  EXPECT_EQ(bench.answer(kEndTen), "");
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{kDone});
  EXPECT_EQ(bench.desk.staged[0], counting(10));
  EXPECT_EQ(bench.desk.hand_ins, 1);
  EXPECT_EQ(bench.answer(kEndTen), "585 80 00 00 00 01 00 04 05") << "a third time: it belongs to nothing";
}

TEST(BlockDownload, GoesOnAfterTheSegmentThatEndsASubBlockCameTwice) {
  BlockBench bench;
  bench.answer("605 C2 10 21 00 0A 00 00 00");
  EXPECT_EQ(bench.answer(kFirst), "");
  EXPECT_EQ(bench.answer("605 83 00 00 00 00 00 00 00"), "585 A2 01 7F 00 00 00 00 00") << "a gap";
  EXPECT_EQ(bench.answer("605 83 00 00 00 00 00 00 00"), "") << "it has been answered";
  EXPECT_EQ(bench.answer("605 81 08 09 0A 00 00 00 00"), "585 A2 01 7F 00 00 00 00 00");
  EXPECT_EQ(bench.answer_in_tick("605 D1 00 00 00 00 00 00 00"), kDone);
}

TEST(BlockDownload, ConfirmsASubBlockWhoseEndIsLost) {
  BlockBench bench;
  bench.answer(kOpenTen);
  bench.answer(kFirst);
  bench.tick(49);
  EXPECT_EQ(bench.drain(), Frames{});
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"585 A2 01 7F 00 00 00 00 00"}) << "after half the time-out, once";
  bench.tick(40);
  EXPECT_EQ(bench.drain(), Frames{});
  EXPECT_EQ(bench.answer("605 81 08 09 0A 00 00 00 00"), "585 A2 01 7F 00 00 00 00 00");
  EXPECT_EQ(bench.answer_in_tick(kEndTen), kDone);
}

TEST(BlockDownload, TimesOutInEachOfItsStates) {
  for (const Frames& before :
       {Frames{kOpenTen}, Frames{kOpenTen, kFirst}, Frames{kOpenTen, kFirst, kSecondLast}}) {
    BlockBench bench;
    for (const std::string& frame : before) bench.answer(frame);
    bench.tick(99);
    for (const std::string& frame : bench.drain()) EXPECT_EQ(frame.substr(0, 6), "585 A2");
    bench.tick();
    EXPECT_EQ(bench.drain(), Frames{"585 80 10 21 00 00 00 04 05"});
    bench.tick(200);
    EXPECT_EQ(bench.drain(), Frames{}) << "once";
    EXPECT_EQ(bench.desk.hand_ins, 0);
  }
}

TEST(BlockDownload, TimesOutThoughAnotherClientAsksAllTheTime) {
  for (const Frames& before : {Frames{kOpenTen}, Frames{kOpenTen, kFirst}}) {
    BlockBench bench;
    for (const std::string& frame : before) bench.answer(frame);
    Frames said;
    for (int tenth = 0; tenth < 12; ++tenth) {
      bench.answer("605 40 00 10 00 00 00 00 00");  // in a sub-block it is a segment out of its turn
      bench.tick(10);
      for (const std::string& frame : bench.drain()) said.push_back(frame);
    }
    EXPECT_EQ(std::count(said.begin(), said.end(), "585 80 10 21 00 00 00 04 05"), 1);
    EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF") << "it is heard";
  }
}

TEST(BlockDownload, WithALostSegmentLivesAsLongAsTheOthersFollowEachOther) {
  BlockBench bench;
  bench.answer("605 C2 10 21 00 A0 00 00 00");
  bench.answer(kFirst);
  for (unsigned number = 3; number <= 22;
       ++number) {  // the second is lost; of a slow bus the rest takes 1.6 s
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    const std::string first{kDigits[number / 16U], kDigits[number % 16U]};
    EXPECT_EQ(bench.answer("605 " + first + " 00 00 00 00 00 00 00"), "");
    bench.tick(8);
    for (const std::string& frame : bench.drain())
      EXPECT_NE(frame.substr(0, 6), "585 80") << "segment " << number;
  }
  EXPECT_EQ(bench.answer("605 97 00 00 00 00 00 00 00"), "585 A2 01 7F 00 00 00 00 00");
}

TEST(BlockDownload, AbortsWithTheCodeThatBelongsAndStagesNothing) {
  struct Case {
    const char* claim;
    Frames frames;
    const char* abort;
  };
  for (const Case& c : {
           Case{"no object", {"605 C6 00 50 00 04 00 00 00"}, "585 80 00 50 00 00 00 02 06"},
           Case{"no sub-index", {"605 C6 10 21 01 04 00 00 00"}, "585 80 10 21 01 11 00 09 06"},
           Case{"read-only", {"605 C6 18 21 00 04 00 00 00"}, "585 80 18 21 00 02 00 01 06"},
           Case{"too long", {"605 C6 10 21 00 A5 00 00 00"}, "585 80 10 21 00 12 00 07 06"},
           Case{"too short", {"605 C6 10 21 00 00 00 00 00"}, "585 80 10 21 00 13 00 07 06"},
           Case{"not the object's size", {"605 C6 17 10 00 04 00 00 00"}, "585 80 17 10 00 12 00 07 06"},
           Case{
               "sequence number 0", {kOpenTen, "605 00 01 02 03 04 05 06 07"}, "585 80 10 21 00 03 00 04 05"},
           Case{"more segments than the size",
                {kOpenTen, kFirst, "605 02 08 09 0A 0B 0C 0D 0E", "605 83 0F 10 11 12 13 14 15"},
                "585 80 10 21 00 10 00 07 06"},
           Case{"fewer bytes than the size",
                {kOpenTen, kFirst, kSecondLast, "605 D5 00 00 00 00 00 00 00"},
                "585 80 10 21 00 04 00 04 05"},
           Case{"fewer bytes than the size, no CRC",
                {"605 C2 10 21 00 0A 00 00 00", kFirst, kSecondLast, "605 D5 00 00 00 00 00 00 00"},
                "585 80 10 21 00 10 00 07 06"},
           Case{"wrong CRC",
                {kOpenTen, kFirst, kSecondLast, "605 D1 4B CC 00 00 00 00 00"},
                "585 80 10 21 00 04 00 04 05"},
           Case{"end request without segments",
                {"605 C1 00 00 00 00 00 00 00"},
                "585 80 00 00 00 01 00 04 05"},
           Case{"refused by the desk",
                {"605 C2 10 21 00 05 00 00 00", "605 81 EE 00 00 00 00 00 00", "605 C9 00 00 00 00 00 00 00"},
                "585 80 10 21 00 20 00 00 08"},
       }) {
    BlockBench bench;
    std::string last;
    for (const std::string& frame : c.frames) last = bench.answer(frame);
    if (bench.desk.hand_ins != 0) {
      bench.tick();
      for (const std::string& frame : bench.drain()) last = frame;
    }
    EXPECT_EQ(last, c.abort) << c.claim;
    EXPECT_EQ(bench.node.counters().sdo_aborts, 1U) << c.claim;
    for (const auto& staged : bench.desk.staged) EXPECT_TRUE(staged.empty()) << c.claim;
    EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF") << c.claim;
  }
}

TEST(BlockDownload, OfUnknownSizeIsBoundedByTheBuffer) {  // 164 bytes: 24 segments, the last with 3
  BlockBench bench;
  bench.answer("605 C0 10 21 00 00 00 00 00");
  for (int i = 1; i <= 24; ++i) {
    char text[] = "605 00 1 2 3 4 5 6 7";
    std::snprintf(text + 4, 3, "%02X", static_cast<unsigned>(i));
    text[6] = ' ';
    EXPECT_EQ(bench.answer(text), "") << i;
  }
  EXPECT_EQ(bench.answer("605 19 1 2 3 4 5 6 7"), "585 80 10 21 00 12 00 07 06");
}

TEST(BlockDownload, IsAbortedByTheClientWithoutAWord) {
  for (const Frames& before : {Frames{kOpenTen, kFirst}, Frames{kOpenTen, kFirst, kSecondLast}}) {
    BlockBench bench;
    for (const std::string& frame : before) bench.answer(frame);
    EXPECT_EQ(bench.answer("605 80 10 21 00 00 00 04 05"), "");
    EXPECT_EQ(bench.answer(kEndTen), "585 80 00 00 00 01 00 04 05");
    EXPECT_EQ(bench.desk.hand_ins, 0);
  }
}

std::string segment(unsigned number, const char* bytes) {
  std::array<char, 3> digits{};
  std::snprintf(digits.data(), digits.size(), "%02X", number);
  return std::string("605 ") + digits.data() + " " + bytes;
}

TEST(BlockDownload, SegmentsThatWereUnderWayWhenItEndedAreNoRequests) {
  constexpr const char* kBytes = "1 2 3 4 5 6 7";
  struct Case {
    const char* claim;
    void (*end)(BlockBench&);
    unsigned goes_on;  ///< with this segment
  };
  const Case cases[] = {
      {"too long", [](BlockBench& bench) { bench.answer(segment(0x19, kBytes)); }, 0x1A},
      {"the last came twice",
       [](BlockBench& bench) {
         bench.answer(segment(0x19, kBytes));
         EXPECT_EQ(bench.answer(segment(0x19, kBytes)), "");
       },
       0x1A},
      {"sequence number 0", [](BlockBench& bench) { bench.answer(segment(0, kBytes)); }, 0x19},
      {"time-out", [](BlockBench& bench) { bench.tick(100); }, 0x19},
      {"time-out, and it was told to begin anew", [](BlockBench& bench) { bench.tick(100); }, 1}};
  for (const Case& c : cases) {
    BlockBench bench;
    bench.answer("605 C0 10 21 00 00 00 00 00");
    for (unsigned i = 1; i <= 0x18; ++i) EXPECT_EQ(bench.answer(segment(i, kBytes)), "");
    c.end(bench);
    bench.drain();
    for (unsigned i = c.goes_on; i <= 0x2A; ++i) EXPECT_EQ(bench.answer(segment(i, kBytes)), "") << c.claim;
    EXPECT_EQ(bench.answer("605 2B 17 10 00 39 05 00 00"), "")
        << c.claim << ": a segment, though it reads as a request";
    EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 00 00 00 00") << c.claim;
    EXPECT_EQ(bench.answer("605 2B 17 10 00 39 05 00 00"), "585 60 17 10 00 00 00 00 00")
        << c.claim << ": a request";
  }
}

TEST(BlockDownload, AfterTheClientsOwnAbortNoSegmentIsUnderWay) {
  BlockBench bench;
  bench.answer("605 C0 10 21 00 00 00 00 00");
  for (unsigned i = 1; i <= 0x16; ++i) bench.answer(segment(i, "1 2 3 4 5 6 7"));
  bench.answer("605 80 10 21 00 00 00 04 05");
  EXPECT_EQ(bench.answer("605 17 00 00 00 00 00 00 00"), "585 80 00 00 00 01 00 04 05")
      << "heard, and refused";
}

TEST(BlockDownload, AfterATimeOutsLengthNoSegmentIsUnderWay) {
  BlockBench bench;
  bench.answer(kOpenTen);
  for (unsigned i = 1; i < 0x2B; ++i) bench.answer(segment(i, "1 2 3 4 5 6 7"));
  bench.answer("605 2B 17 10 00 39 05 00 00");
  bench.tick(201);
  bench.drain();
  EXPECT_EQ(bench.answer("605 2B 17 10 00 39 05 00 00"), "585 60 17 10 00 00 00 00 00");
}

TEST(BlockDownload, GivesWayToANewRequestBetweenItsLastSegmentAndItsEnd) {
  BlockBench bench;
  bench.answer(kOpenTen);
  bench.answer(kFirst);
  bench.answer(kSecondLast);
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF");
  EXPECT_EQ(bench.answer(kEndTen), "585 80 00 00 00 01 00 04 05");
  EXPECT_EQ(bench.desk.hand_ins, 0);
}

// ---- upload ----

/// Chamber 2's active image, 10 bytes 01h..0Ah.
struct UploadBench : BlockBench {
  explicit UploadBench(std::size_t size = 10) { desk.active[2] = counting(size); }
};

TEST(BlockUpload, SendsTenBytesInTwoSegments) {
  UploadBench bench;
  EXPECT_EQ(bench.answer("605 A4 1A 21 00 7F 00 00 00"), "585 C6 1A 21 00 0A 00 00 00");
  EXPECT_EQ(bench.drain(), Frames{}) << "not before the client starts it";
  bench.send("605 A3 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.drain(), (Frames{"585 01 01 02 03 04 05 06 07", "585 82 08 09 0A 00 00 00 00"}));
  EXPECT_EQ(bench.answer("605 A2 02 7F 00 00 00 00 00"), "585 D1 4B CD 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 A1 00 00 00 00 00 00 00"), "");
  bench.tick(200);
  EXPECT_EQ(bench.drain(), Frames{}) << "the transfer is over";
}

TEST(BlockUpload, LeavesTheCrcAtZeroWhenTheClientWantsNone) {
  UploadBench bench;
  EXPECT_EQ(bench.answer("605 A0 1A 21 00 7F 00 00 00"), "585 C6 1A 21 00 0A 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  bench.drain();
  EXPECT_EQ(bench.answer("605 A2 02 7F 00 00 00 00 00"), "585 D1 00 00 00 00 00 00 00");
}

TEST(BlockUpload, EndsWithASegmentThatIsFull) {
  UploadBench bench(14);
  bench.answer("605 A4 1A 21 00 7F 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.drain(), (Frames{"585 01 01 02 03 04 05 06 07", "585 82 08 09 0A 0B 0C 0D 0E"}));
  EXPECT_EQ(bench.answer("605 A2 02 7F 00 00 00 00 00"), "585 C1 92 9B 00 00 00 00 00");
}

TEST(BlockUpload, KeepsToTheBlockSizeOfTheClientAndFollowsItsChanges) {
  UploadBench bench(25);
  bench.answer("605 A4 1A 21 00 01 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.drain(), Frames{"585 01 01 02 03 04 05 06 07"});
  bench.send("605 A2 01 02 00 00 00 00 00");
  EXPECT_EQ(bench.drain(), (Frames{"585 01 08 09 0A 0B 0C 0D 0E", "585 02 0F 10 11 12 13 14 15"}));
  bench.send("605 A2 02 05 00 00 00 00 00");
  EXPECT_EQ(bench.drain(), Frames{"585 81 16 17 18 19 00 00 00"});
  EXPECT_EQ(bench.answer("605 A2 01 05 00 00 00 00 00"), "585 CD 7F 9A 00 00 00 00 00");
}

TEST(BlockUpload, SendsAgainFromTheFirstSegmentThatTheClientMissed) {
  UploadBench bench(25);
  bench.answer("605 A4 1A 21 00 7F 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.drain().size(), 4U);
  bench.send("605 A2 01 7F 00 00 00 00 00");
  EXPECT_EQ(bench.drain(), (Frames{"585 01 08 09 0A 0B 0C 0D 0E", "585 02 0F 10 11 12 13 14 15",
                                   "585 83 16 17 18 19 00 00 00"}));
  bench.send("605 A2 00 7F 00 00 00 00 00");
  EXPECT_EQ(bench.drain().size(), 3U) << "nothing arrived: all of it again";
  EXPECT_EQ(bench.answer("605 A2 03 7F 00 00 00 00 00"), "585 CD 7F 9A 00 00 00 00 00")
      << "the CRC is that of the value, not of the wire";
}

TEST(BlockUpload, LeavesDuplicatesOfTheClientAlone) {
  UploadBench bench(25);
  bench.answer("605 A4 1A 21 00 02 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.drain().size(), 2U);
  bench.send("605 A2 02 7F 00 00 00 00 00");
  bench.send("605 A2 02 7F 00 00 00 00 00");
  EXPECT_EQ(bench.drain(), (Frames{"585 01 0F 10 11 12 13 14 15", "585 82 16 17 18 19 00 00 00"}));
  EXPECT_EQ(bench.answer("605 A2 02 05 00 00 00 00 00"), "585 CD 7F 9A 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 A2 02 05 00 00 00 00 00"), "");
  EXPECT_EQ(bench.answer("605 A1 00 00 00 00 00 00 00"), "");
}

TEST(BlockUpload, SwitchesToTheSegmentedProtocolForWhatIsShort) {
  UploadBench bench;
  EXPECT_EQ(bench.answer("605 A4 1A 21 00 7F 0A 00 00"), "585 41 1A 21 00 0A 00 00 00")
      << "10 bytes or fewer";
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 00 01 02 03 04 05 06 07");
  EXPECT_EQ(bench.answer("605 A4 1A 21 00 7F 09 00 00"), "585 C6 1A 21 00 0A 00 00 00");
  EXPECT_EQ(bench.answer("605 A4 00 10 00 7F 04 00 00"), "585 43 00 10 00 98 01 FF FF") << "expedited";
  EXPECT_EQ(bench.answer("605 A4 00 10 00 7F 00 00 00"), "585 C6 00 10 00 04 00 00 00");
}

TEST(BlockUpload, AbortsWithTheCodeThatBelongs) {
  const std::string open = "605 A4 1A 21 00 7F 00 00 00";
  const std::string start = "605 A3 00 00 00 00 00 00 00";
  struct Case {
    const char* claim;
    Frames frames;
    const char* abort;
  };
  for (const Case& c : {
           Case{"no object", {"605 A4 00 50 00 7F 00 00 00"}, "585 80 00 50 00 00 00 02 06"},
           Case{"write-only", {"605 A4 10 21 00 7F 00 00 00"}, "585 80 10 21 00 01 00 01 06"},
           Case{"nothing there", {"605 A4 18 21 00 7F 00 00 00"}, "585 80 18 21 00 24 00 00 08"},
           Case{"block size 0", {"605 A4 1A 21 00 00 00 00 00"}, "585 80 1A 21 00 02 00 04 05"},
           Case{"block size 128", {"605 A4 1A 21 00 80 00 00 00"}, "585 80 1A 21 00 02 00 04 05"},
           Case{"start of nothing", {start}, "585 80 00 00 00 01 00 04 05"},
           Case{"confirmation before the start",
                {open, "605 A2 00 7F 00 00 00 00 00"},
                "585 80 1A 21 00 01 00 04 05"},
           Case{"end before the end",
                {open, start, "605 A1 00 00 00 00 00 00 00"},
                "585 80 1A 21 00 01 00 04 05"},
           Case{"more confirmed than sent",
                {open, start, "605 A2 03 7F 00 00 00 00 00"},
                "585 80 1A 21 00 03 00 04 05"},
           Case{"new block size 0",
                {open, start, "605 A2 01 00 00 00 00 00 00"},
                "585 80 1A 21 00 02 00 04 05"},
           Case{"new block size 128",
                {open, start, "605 A2 01 80 00 00 00 00 00"},
                "585 80 1A 21 00 02 00 04 05"},
           Case{"segment of the other protocol",
                {open, start, "605 60 00 00 00 00 00 00 00"},
                "585 80 1A 21 00 01 00 04 05"},
       }) {
    UploadBench bench;
    std::string last;
    for (const std::string& frame : c.frames) {
      bench.send(frame);
      const Frames frames = bench.drain();
      last = frames.empty() ? "" : frames.back();
    }
    EXPECT_EQ(last, c.abort) << c.claim;
    bench.tick(200);
    EXPECT_EQ(bench.drain(), Frames{}) << c.claim;
  }
}

TEST(BlockUpload, TimesOutInEachOfItsStates) {
  const Frames all = {"605 A4 1A 21 00 7F 00 00 00", "605 A3 00 00 00 00 00 00 00",
                      "605 A2 02 7F 00 00 00 00 00"};
  for (std::size_t known = 1; known <= all.size(); ++known) {
    UploadBench bench;
    for (std::size_t i = 0; i < known; ++i) {
      bench.send(all[i]);
      bench.drain();
    }
    bench.tick(99);
    EXPECT_EQ(bench.drain(), Frames{});
    bench.tick();
    EXPECT_EQ(bench.drain(), Frames{"585 80 1A 21 00 00 00 04 05"});
  }
}

TEST(BlockUpload, TimesOutOnABusThatTakesNothing) {
  UploadBench bench;
  bench.answer("605 A4 1A 21 00 7F 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  bench.tick(100);
  EXPECT_EQ(bench.drain(), Frames{"585 80 1A 21 00 00 00 04 05"});
}

TEST(BlockUpload, OutlivesABusThatIsSlow) {
  UploadBench bench(21);
  bench.answer("605 A4 1A 21 00 7F 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  ports::CanFrame frame;
  for (const char* segment :
       {"585 01 01 02 03 04 05 06 07", "585 02 08 09 0A 0B 0C 0D 0E", "585 83 0F 10 11 12 13 14 15"}) {
    bench.tick(60);
    ASSERT_TRUE(bench.node.next_frame(frame));
    EXPECT_EQ(text_of(frame), segment);
  }
}

TEST(BlockUpload, LetsEverythingElseGoFirst) {
  UploadBench bench(70);
  bench.send("000 01 05");
  bench.tick();
  bench.drain();
  bench.answer("605 A4 1A 21 00 7F 00 00 00");
  bench.send("605 A3 00 00 00 00 00 00 00");
  ports::CanFrame frame;
  ASSERT_TRUE(bench.node.next_frame(frame));
  EXPECT_EQ(text_of(frame), "585 01 01 02 03 04 05 06 07");
  bench.image.error_code = 0x5000;
  bench.send("080");
  bench.tick();
  Frames frames = bench.drain();
  ASSERT_EQ(frames.size(), 13U);
  EXPECT_EQ(frames[0].substr(0, 3), "085");
  EXPECT_EQ(frames[1].substr(0, 3), "185");
  EXPECT_EQ(frames[2].substr(0, 3), "285");
  EXPECT_EQ(frames[3].substr(0, 3), "485");
  for (std::size_t i = 4; i < 13; ++i) EXPECT_EQ(frames[i].substr(0, 3), "585");
}

TEST(BlockUpload, TakesNoMoreThanItsShareOfATick) {
  UploadBench bench;
  bench.desk.active[2] = counting(160);
  int most = 0;
  for (int round = 0; round < 3; ++round) {  // 3 transfers of 23 segments: 69
    bench.answer("605 A4 1A 21 00 7F 00 00 00");
    bench.send("605 A3 00 00 00 00 00 00 00");
    most += static_cast<int>(bench.drain().size());
  }
  EXPECT_EQ(most, 64);
  bench.tick();
  EXPECT_EQ(bench.drain().size(), 5U);
}

}  // namespace
}  // namespace plenum::canopen
