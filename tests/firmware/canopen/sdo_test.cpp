// SDO transfers, frame by frame, written from CiA 301 7.2.4.3 and not by the code under test.
#include <gtest/gtest.h>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

TEST(Sdo, ReadsTheDeviceTypeExpedited) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF");
}

TEST(Sdo, ReadsOneTwoAndFourBytes) {
  Bench bench;
  bench.image.status_word = 0x0009;
  EXPECT_EQ(bench.answer("605 40 01 10 00 00 00 00 00"), "585 4F 01 10 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 41 60 00 00 00 00 00"), "585 4B 41 60 00 09 00 00 00");
  EXPECT_EQ(bench.answer("605 40 18 10 04 00 00 00 00"), "585 43 18 10 04 44 00 00 00");
}

TEST(Sdo, WritesTheHeartbeatTimeExpedited) {  // the example of every CANopen primer: 1017h = 1000 ms
  Bench bench;
  EXPECT_EQ(bench.answer("605 2B 17 10 00 E8 03 00 00"), "585 60 17 10 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 E8 03 00 00");
}

TEST(Sdo, TakesAnExpeditedSizeLeftOpenFromTheObject) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 22 17 10 00 F4 01 00 00"), "585 60 17 10 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 F4 01 00 00");
}

TEST(Sdo, ReadsTheDeviceNameInSegments) {  // "Plenum valve board", 18 bytes
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 08 10 00 00 00 00 00"), "585 41 08 10 00 12 00 00 00");
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 00 50 6C 65 6E 75 6D 20");
  EXPECT_EQ(bench.answer("605 70 00 00 00 00 00 00 00"), "585 10 76 61 6C 76 65 20 62");
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 07 6F 61 72 64 00 00 00");  // 3 unused, last
  EXPECT_EQ(bench.answer("605 70 00 00 00 00 00 00 00"), "585 80 00 00 00 01 00 04 05")
      << "nothing is under way";
}

TEST(Sdo, LeavesALastSegmentThatComesTwiceAlone) {
  Bench bench;
  bench.answer("605 21 17 10 00 02 00 00 00");
  bench.answer("605 0B 2C 01 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 0B 2C 01 00 00 00 00 00"), "")
      << "an abort would end the client's next transfer";
  EXPECT_EQ(bench.answer("605 0B 2C 01 00 00 00 00 00"), "585 80 00 00 00 01 00 04 05") << "a third time";
  bench.answer("605 40 08 10 00 00 00 00 00");
  bench.answer("605 60 00 00 00 00 00 00 00");
  bench.answer("605 70 00 00 00 00 00 00 00");
  bench.answer("605 60 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "");
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 2C 01 00 00");
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 2C 01 00 00")
      << "a request that begins a transfer is answered each time";
  EXPECT_EQ(bench.answer("605 00 00 00 00 00 00 00 00"), "585 80 00 00 00 01 00 04 05");
}

TEST(Sdo, WritesAScalarInSegmentsToo) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 21 17 10 00 02 00 00 00"), "585 60 17 10 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 0B 2C 01 00 00 00 00 00"), "585 20 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 2C 01 00 00");
}

/// An image of 160 bytes 00h..9Fh in 23 segments: 22 of seven bytes and one of six.
TEST(Sdo, TakesAnImageOf160BytesInSegments) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 21 13 21 00 A0 00 00 00"), "585 60 13 21 00 00 00 00 00");
  const Frames segments = {
      "605 00 00 01 02 03 04 05 06", "605 10 07 08 09 0A 0B 0C 0D", "605 00 0E 0F 10 11 12 13 14",
      "605 10 15 16 17 18 19 1A 1B", "605 00 1C 1D 1E 1F 20 21 22", "605 10 23 24 25 26 27 28 29",
      "605 00 2A 2B 2C 2D 2E 2F 30", "605 10 31 32 33 34 35 36 37", "605 00 38 39 3A 3B 3C 3D 3E",
      "605 10 3F 40 41 42 43 44 45", "605 00 46 47 48 49 4A 4B 4C", "605 10 4D 4E 4F 50 51 52 53",
      "605 00 54 55 56 57 58 59 5A", "605 10 5B 5C 5D 5E 5F 60 61", "605 00 62 63 64 65 66 67 68",
      "605 10 69 6A 6B 6C 6D 6E 6F", "605 00 70 71 72 73 74 75 76", "605 10 77 78 79 7A 7B 7C 7D",
      "605 00 7E 7F 80 81 82 83 84", "605 10 85 86 87 88 89 8A 8B", "605 00 8C 8D 8E 8F 90 91 92",
      "605 10 93 94 95 96 97 98 99", "605 03 9A 9B 9C 9D 9E 9F 00"};
  for (std::size_t i = 0; i < segments.size(); ++i) {
    EXPECT_EQ(bench.desk.hand_ins, 0) << "nothing is handed in before the last segment";
    const bool is_last = i + 1 == segments.size();
    EXPECT_EQ(is_last ? bench.answer_in_tick(segments[i]) : bench.answer(segments[i]),
              i % 2 == 0 ? "585 20 00 00 00 00 00 00 00" : "585 30 00 00 00 00 00 00 00");
  }
  ASSERT_EQ(bench.desk.staged[3].size(), 160U);
  for (std::size_t i = 0; i < 160; ++i) EXPECT_EQ(bench.desk.staged[3][i], i);
  EXPECT_EQ(bench.desk.hand_ins, 1);
}

TEST(Sdo, ReadsTheActiveImageInSegments) {
  Bench bench;
  bench.desk.active[1] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
  EXPECT_EQ(bench.answer("605 40 19 21 00 00 00 00 00"), "585 41 19 21 00 0E 00 00 00");
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 00 01 02 03 04 05 06 07");
  bench.desk.active[1].assign(14,
                              0xAA);  // taken over meanwhile: the transfer goes on with what it began with
  EXPECT_EQ(bench.answer("605 70 00 00 00 00 00 00 00"), "585 11 08 09 0A 0B 0C 0D 0E");
}

TEST(Sdo, AbortsWithTheCodeThatBelongs) {
  struct Case {
    const char* claim;
    const char* request;
    const char* answer;
  };
  for (const Case& c : {
           Case{"no object", "605 40 00 50 00 00 00 00 00", "585 80 00 50 00 00 00 02 06"},
           Case{"no object between two chambers", "605 40 80 67 01 00 00 00 00",
                "585 80 80 67 01 00 00 02 06"},
           Case{"no ninth chamber", "605 40 80 A3 01 00 00 00 00", "585 80 80 A3 01 00 00 02 06"},
           Case{"no sub-index", "605 40 18 10 05 00 00 00 00", "585 80 18 10 05 11 00 09 06"},
           Case{"no reserved sub-index", "605 40 00 18 04 00 00 00 00", "585 80 00 18 04 11 00 09 06"},
           Case{"write to read-only", "605 2B 41 60 00 00 00 00 00", "585 80 41 60 00 02 00 01 06"},
           Case{"write to a constant", "605 23 00 10 00 00 00 00 00", "585 80 00 10 00 02 00 01 06"},
           Case{"read of write-only", "605 40 10 21 00 00 00 00 00", "585 80 10 21 00 01 00 01 06"},
           Case{"too long", "605 23 17 10 00 00 00 00 00", "585 80 17 10 00 12 00 07 06"},
           Case{"too short", "605 2F 17 10 00 00 00 00 00", "585 80 17 10 00 13 00 07 06"},
           Case{"announced too long", "605 21 17 10 00 03 00 00 00", "585 80 17 10 00 12 00 07 06"},
           Case{"announced too short", "605 21 17 10 00 01 00 00 00", "585 80 17 10 00 13 00 07 06"},
           Case{"image larger than any", "605 21 10 21 00 A5 00 00 00", "585 80 10 21 00 12 00 07 06"},
           Case{"image of no bytes", "605 21 10 21 00 00 00 00 00", "585 80 10 21 00 13 00 07 06"},
           Case{"NaN set point", "605 23 50 21 01 00 00 C0 7F", "585 80 50 21 01 30 00 09 06"},
           Case{"infinite set point", "605 23 50 21 01 00 00 80 7F", "585 80 50 21 01 30 00 09 06"},
           Case{"negative set point", "605 2B 80 63 01 FF FF 00 00", "585 80 80 63 01 32 00 09 06"},
           Case{"device mode off the bus", "605 2F 42 60 00 02 00 00 00", "585 80 42 60 00 31 00 09 06"},
           Case{"unknown control mode", "605 2F 43 60 00 02 00 00 00", "585 80 43 60 00 30 00 09 06"},
           Case{"error history set", "605 2F 03 10 00 01 00 00 00", "585 80 03 10 00 30 00 09 06"},
           Case{"empty error history", "605 40 03 10 01 00 00 00 00", "585 80 03 10 01 24 00 00 08"},
           Case{"no active image", "605 40 18 21 00 00 00 00 00", "585 80 18 21 00 24 00 00 08"},
           Case{"segment out of the blue", "605 00 01 02 03 04 05 06 07", "585 80 00 00 00 01 00 04 05"},
           Case{"SYNC with 29 bits", "605 23 05 10 00 80 00 00 20", "585 80 05 10 00 30 00 09 06"},
           Case{"SYNC on an SDO identifier", "605 23 05 10 00 05 06 00 00", "585 80 05 10 00 30 00 09 06"},
           Case{"SYNC on the NMT identifier", "605 23 05 10 00 00 00 00 00", "585 80 05 10 00 30 00 09 06"},
           Case{"restricted COB-ID", "605 23 04 18 01 05 06 00 00", "585 80 04 18 01 30 00 09 06"},
           Case{"COB-ID of a living PDO", "605 23 00 18 01 86 01 00 40", "585 80 00 18 01 30 00 09 06"},
           Case{"reserved transmission type", "605 2F 00 18 02 F1 00 00 00", "585 80 00 18 02 30 00 09 06"},
           Case{"transmission on RTR", "605 2F 00 18 02 FD 00 00 00", "585 80 00 18 02 30 00 09 06"},
           Case{"inhibit time of a living PDO", "605 2B 00 18 03 01 00 00 00", "585 80 00 18 03 22 00 00 08"},
           Case{"mapping of a living PDO", "605 2F 00 1A 00 00 00 00 00", "585 80 00 1A 00 22 00 00 08"},
           Case{"entry of an active mapping", "605 23 04 1A 01 20 02 50 21", "585 80 04 1A 01 22 00 00 08"},
           Case{"commit with a wrong key", "605 23 20 21 03 00 00 00 00", "585 80 20 21 03 30 00 09 06"},
           Case{"commit of nothing", "605 23 20 21 03 63 6F 6D 74", "585 80 20 21 03 20 00 00 08"},
       }) {
    Bench bench;
    EXPECT_EQ(bench.answer(c.request), c.answer) << c.claim;
    EXPECT_EQ(bench.node.counters().sdo_aborts, 1U) << c.claim;
  }
}

TEST(Sdo, AbortsADownloadWhoseToggleBitStandsStill) {
  Bench bench;
  bench.answer("605 21 10 21 00 10 00 00 00");
  EXPECT_EQ(bench.answer("605 00 01 02 03 04 05 06 07"), "585 20 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 00 01 02 03 04 05 06 07"), "585 80 10 21 00 00 00 03 05") << "a duplicate";
  EXPECT_EQ(bench.answer("605 10 01 02 03 04 05 06 07"), "585 80 00 00 00 01 00 04 05")
      << "the transfer is over";
  EXPECT_EQ(bench.desk.hand_ins, 0);
}

TEST(Sdo, AbortsAnUploadWhoseToggleBitStandsStill) {
  Bench bench;
  bench.answer("605 40 08 10 00 00 00 00 00");
  bench.answer("605 60 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 80 08 10 00 00 00 03 05");
}

TEST(Sdo, AbortsWhenSegmentsDoNotAddUpToTheAnnouncedSize) {
  Bench more;
  more.answer("605 21 10 21 00 08 00 00 00");
  more.answer("605 00 01 02 03 04 05 06 07");
  EXPECT_EQ(more.answer("605 10 01 02 03 04 05 06 07"), "585 80 10 21 00 10 00 07 06");
  Bench fewer;
  fewer.answer("605 21 10 21 00 08 00 00 00");
  EXPECT_EQ(fewer.answer("605 01 01 02 03 04 05 06 07"), "585 80 10 21 00 10 00 07 06");
  EXPECT_EQ(more.desk.hand_ins + fewer.desk.hand_ins, 0);
}

TEST(Sdo, BoundsADownloadOfUnknownSize) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 20 10 21 00 00 00 00 00"), "585 60 10 21 00 00 00 00 00");
  std::string last;
  for (int i = 0; i < 23; ++i)
    last = bench.answer(i % 2 == 0 ? "605 00 1 2 3 4 5 6 7" : "605 10 1 2 3 4 5 6 7");
  EXPECT_EQ(last, "585 20 00 00 00 00 00 00 00") << "161 bytes of 164";
  EXPECT_EQ(bench.answer("605 10 1 2 3 4 5 6 7"), "585 80 10 21 00 12 00 07 06");
}

TEST(Sdo, LetsTheClientAbortWithoutAWord) {
  Bench bench;
  bench.answer("605 21 10 21 00 08 00 00 00");
  EXPECT_EQ(bench.answer("605 80 10 21 00 00 00 04 05"), "");
  EXPECT_EQ(bench.answer("605 00 01 02 03 04 05 06 07"), "585 80 00 00 00 01 00 04 05");
}

TEST(Sdo, StartsAnewWhenTheClientDoes) {
  Bench bench;
  bench.answer("605 21 10 21 00 08 00 00 00");
  bench.answer("605 00 EE EE EE EE EE EE EE");
  EXPECT_EQ(bench.answer("605 21 11 21 00 05 00 00 00"), "585 60 11 21 00 00 00 00 00");
  EXPECT_EQ(bench.answer_in_tick("605 05 01 02 03 04 05 00 00"), "585 20 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.desk.staged[1], (std::vector<std::uint8_t>{1, 2, 3, 4, 5}));
  EXPECT_TRUE(bench.desk.staged[0].empty());
}

TEST(Sdo, TimesOutASilentTransferAfterOneSecond) {
  Bench bench;
  bench.answer("605 2B 17 10 00 00 00 00 00");  // no heartbeat in between
  bench.answer("605 21 10 21 00 08 00 00 00");
  bench.tick(99);
  EXPECT_EQ(bench.drain(), Frames{});
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"585 80 10 21 00 00 00 04 05"});
  bench.tick(200);
  EXPECT_EQ(bench.drain(), Frames{}) << "once";
}

TEST(Sdo, CountsTheSilenceFromTheLastSegment) {
  Bench bench;
  bench.answer("605 2B 17 10 00 00 00 00 00");
  bench.answer("605 21 10 21 00 0E 00 00 00");
  bench.tick(90);
  EXPECT_EQ(bench.answer("605 00 01 02 03 04 05 06 07"), "585 20 00 00 00 00 00 00 00");
  bench.tick(90);
  EXPECT_EQ(bench.answer_in_tick("605 11 01 02 03 04 05 06 07"), "585 30 00 00 00 00 00 00 00");
  EXPECT_EQ(bench.desk.hand_ins, 1);
}

TEST(Sdo, PassesTheDesksJudgementOn) {
  Bench bench;
  const auto upload = [&] {
    bench.answer("605 21 10 21 00 05 00 00 00");
    return bench.answer_in_tick("605 05 EE 00 00 00 00 00 00");
  };
  EXPECT_EQ(upload(), "585 80 10 21 00 20 00 00 08") << "bad CRC";
  bench.desk.refusal = config::ImageError::out_of_range;
  EXPECT_EQ(upload(), "585 80 10 21 00 31 00 09 06") << "7 of 1..5";
  bench.desk.refused_value = 0.5F;
  EXPECT_EQ(upload(), "585 80 10 21 00 32 00 09 06") << "0.5 of 1..5";
  for (const auto error : {config::ImageError::not_finite, config::ImageError::not_admissible}) {
    bench.desk.refusal = error;
    EXPECT_EQ(upload(), "585 80 10 21 00 30 00 09 06");
  }
  EXPECT_EQ(bench.answer("605 40 28 21 01 00 00 00 00"), "585 4F 28 21 01 04 00 00 00");
  EXPECT_EQ(bench.answer("605 40 28 21 03 00 00 00 00"), "585 43 28 21 03 44 33 22 11");
  EXPECT_EQ(bench.answer("605 40 28 21 05 00 00 00 00"), "585 4F 28 21 05 02 00 00 00");
  EXPECT_EQ(bench.answer("605 40 28 21 06 00 00 00 00"), "585 43 28 21 06 00 00 E0 40") << "7.0";
}

TEST(Sdo, SaysAtOnceWhyAnImageIsNotEvenJudged) {
  Bench bench;
  for (const auto error : {config::ImageError::commit_pending, config::ImageError::staged_by_another}) {
    bench.desk.not_let_in = error;
    bench.answer("605 21 10 21 00 05 00 00 00");
    EXPECT_EQ(bench.answer("605 05 01 02 03 04 05 00 00"), "585 80 10 21 00 22 00 00 08");
  }
}

/// An image of five bytes that the desk has been handed in, and has not judged.
struct Judged : Bench {
  explicit Judged(const std::string& last = "605 05 01 02 03 04 05 00 00") {
    answer("605 21 10 21 00 05 00 00 00");
    EXPECT_EQ(answer(last), "");
    EXPECT_EQ(desk.hand_ins, 1);
  }
};

TEST(Sdo, RefusesAllElseWhileAnImageIsJudgedAndAnswersItAllTheSame) {
  Judged bench;
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 80 00 10 00 22 00 00 08");
  EXPECT_EQ(bench.answer("605 21 11 21 00 05 00 00 00"), "585 80 11 21 00 22 00 00 08") << "another master";
  EXPECT_EQ(bench.answer("605 2B 40 60 00 07 00 00 00"), "585 80 40 60 00 22 00 00 08");
  EXPECT_EQ(bench.image.control_word, 0);
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"585 20 00 00 00 00 00 00 00"});
  EXPECT_EQ(bench.desk.hand_ins, 1);
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF");
}

TEST(Sdo, HandsInOnceAnImageWhoseLastSegmentComesTwice) {
  Judged bench;
  EXPECT_EQ(bench.answer("605 05 01 02 03 04 05 00 00"), "");
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"585 20 00 00 00 00 00 00 00"});
  EXPECT_EQ(bench.desk.hand_ins, 1);
}

TEST(Sdo, JudgesAnImageWhoseClientHasGivenUpAndSaysNothing) {
  for (const char* last : {"605 05 01 02 03 04 05 00 00", "605 05 EE 02 03 04 05 00 00"}) {
    Judged bench(last);
    EXPECT_EQ(bench.answer("605 80 10 21 00 00 00 04 05"), "");
    EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF");
    bench.tick();
    EXPECT_EQ(bench.drain(), Frames{});
    EXPECT_FALSE(bench.desk.judged.pending);
  }
}

TEST(Sdo, ForgetsWhoWaitsForAJudgementWithTheCommunication) {
  for (const char* command : {"000 82 05", "000 02 05"}) {
    Judged bench;
    bench.send(command);
    bench.tick();
    for (const std::string& frame : bench.drain()) EXPECT_EQ(frame, "705 00") << command;
  }
}

TEST(Sdo, DoesNotTakeAnOrderToTheStoreForAJudgement) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 23 10 10 01 73 61 76 65"), "");
  EXPECT_EQ(bench.answer("605 80 10 10 01 00 00 04 05"), "") << "its client gives up";
  bench.answer("605 21 10 21 00 05 00 00 00");
  EXPECT_EQ(bench.answer("605 05 EE 02 03 04 05 00 00"), "");
  bench.node.order().done = true;
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"585 80 10 21 00 20 00 00 08"}) << "the image's own";
  EXPECT_EQ(bench.node.order().what, StoreOrder::What::none);
}

TEST(Sdo, CommitsOnceAndRefusesTheReplay) {
  Bench bench;
  bench.answer("605 21 12 21 00 05 00 00 00");
  bench.answer_in_tick("605 05 01 31 32 33 34 00 00");  // trailing CRC bytes 31 32 33 34
  EXPECT_EQ(bench.answer("605 2F 20 21 01 04 00 00 00"), "585 60 20 21 01 00 00 00 00");
  // CRC-32 of "1234" is 9BE3E0A3h
  EXPECT_EQ(bench.answer("605 23 20 21 02 A3 E0 E3 9B"), "585 60 20 21 02 00 00 00 00");
  EXPECT_EQ(bench.answer("605 23 20 21 03 63 6F 6D 74"), "585 60 20 21 03 00 00 00 00");
  EXPECT_EQ(bench.desk.commits, 1);
  EXPECT_EQ(bench.answer("605 23 20 21 03 63 6F 6D 74"), "585 80 20 21 03 20 00 00 08");
  EXPECT_EQ(bench.desk.commits, 1);
}

TEST(Sdo, RefusesACommitWithAWrongCrcOrAtTheWrongTime) {
  Bench bench;
  bench.answer("605 2F 20 21 01 04 00 00 00");
  EXPECT_EQ(bench.answer("605 23 20 21 03 63 6F 6D 74"), "585 80 20 21 03 20 00 00 08");
  bench.desk.held_back = config::CommitResult::not_now;
  bench.answer("605 2F 20 21 01 04 00 00 00");
  EXPECT_EQ(bench.answer("605 23 20 21 03 63 6F 6D 74"), "585 80 20 21 03 22 00 00 08");
  EXPECT_EQ(bench.desk.commits, 0);
}

TEST(Sdo, IgnoresFramesThatAreNoRequestsOfItsOwn) {
  Bench bench;
  EXPECT_EQ(bench.answer("606 2B 17 10 00 05 00 00 00"), "") << "another node's";
  EXPECT_EQ(bench.answer("605 2B 17 10 00 05 00 00"), "") << "seven bytes";
  EXPECT_EQ(bench.answer("585 2B 17 10 00 05 00 00 00"), "") << "an answer";
  ports::CanFrame frame = frame_from("605 2B 17 10 00 05 00 00 00");
  frame.extended = true;
  bench.node.receive(frame);
  frame.extended = false;
  frame.remote = true;
  bench.node.receive(frame);
  EXPECT_EQ(bench.drain(), Frames{});
  EXPECT_EQ(bench.answer("605 40 17 10 00 00 00 00 00"), "585 4B 17 10 00 E8 03 00 00")
      << "still the default";
}

TEST(Sdo, LetsBit30OfAnRpdosIdentifierBe) {  // CiA 301: do not care
  Bench bench;
  EXPECT_EQ(bench.answer("605 23 00 14 01 05 02 00 40"), "585 60 00 14 01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 00 14 01 00 00 00 00"), "585 43 00 14 01 05 02 00 40");
  EXPECT_EQ(bench.answer("605 23 00 14 01 05 02 00 20"), "585 80 00 14 01 30 00 09 06") << "29 bits";
}

TEST(Sdo, KeepsBit30OfATpdosIdentifierAsWrittenAndTakesNoTypeThatNeedsRemoteFrames) {
  for (const char* cob_id : {"85 01 00 00", "85 01 00 40"}) {
    Bench bench;
    const std::string bytes = cob_id;
    EXPECT_EQ(bench.answer("605 23 00 18 01 " + bytes), "585 60 00 18 01 00 00 00 00");
    EXPECT_EQ(bench.answer("605 40 00 18 01 00 00 00 00"), "585 43 00 18 01 " + bytes);
    for (const char* type : {"FC", "FD"}) {
      EXPECT_EQ(bench.answer(std::string("605 2F 00 18 02 ") + type + " 00 00 00"),
                "585 80 00 18 02 30 00 09 06");
    }
  }
}

TEST(Sdo, RefusesEveryIdentifierThatCia301Restricts) {
  for (const char* object : {"05 10 00", "14 10 00", "03 14 01", "04 18 01"}) {
    Bench bench;
    const std::string at = object;
    bench.answer("605 23 14 10 00 85 00 00 80");  // so that EMCY may have another
    for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
      const bool restricted = id <= 0x7F || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) ||
                              (id >= 0x601 && id <= 0x67F) || (id >= 0x6E0 && id <= 0x6FF) || id >= 0x701;
      if (!restricted) continue;
      std::array<char, 32> bytes{};
      std::snprintf(bytes.data(), bytes.size(), " %02X %02X 00 00", id & 0xFF, id >> 8);
      ASSERT_EQ(bench.answer("605 23 " + at + bytes.data()), "585 80 " + at + " 30 00 09 06") << bytes.data();
    }
  }
}

TEST(Sdo, RefusesAnIdentifierThatAnotherObjectOfTheNodeHas) {
  struct Case {
    const char* claim;
    const char* object;
    const char* cob_id;
  };
  for (const Case& c :
       {Case{"SYNC on EMCY", "05 10 00", "85 00 00 00"}, Case{"SYNC on RPDO1", "05 10 00", "05 02 00 00"},
        Case{"SYNC on TPDO3", "05 10 00", "85 03 00 00"}, Case{"EMCY on SYNC", "14 10 00", "80 00 00 00"},
        Case{"EMCY on TPDO1", "14 10 00", "85 01 00 00"}, Case{"RPDO4 on SYNC", "03 14 01", "80 00 00 00"},
        Case{"RPDO4 on TPDO1", "03 14 01", "85 01 00 00"}, Case{"TPDO5 on SYNC", "04 18 01", "80 00 00 40"},
        Case{"TPDO5 on EMCY", "04 18 01", "85 00 00 40"}, Case{"TPDO5 on RPDO2", "04 18 01", "05 03 00 40"},
        Case{"TPDO5 on TPDO2", "04 18 01", "85 02 00 00"}}) {
    Bench bench;
    const std::string at = c.object;
    if (at == "14 10 00") bench.answer("605 23 14 10 00 85 00 00 80");
    const std::string before = bench.answer("605 40 " + at + " 00 00 00 00");
    EXPECT_EQ(bench.answer("605 23 " + at + ' ' + c.cob_id), "585 80 " + at + " 30 00 09 06") << c.claim;
    EXPECT_EQ(bench.answer("605 40 " + at + " 00 00 00 00"), before) << c.claim;
  }
}

TEST(Sdo, LetsRpdosShareAnIdentifierAndAnObjectHaveThatOfOneSwitchedOff) {
  Bench bench;
  const std::string ok = "00 00 00 00";
  EXPECT_EQ(bench.answer("605 23 03 14 01 05 04 00 00"), "585 60 03 14 01 " + ok) << "RPDO4 on RPDO3";
  EXPECT_EQ(bench.answer("605 23 00 18 01 85 01 00 40"), "585 60 00 18 01 " + ok) << "its own once more";
  EXPECT_EQ(bench.answer("605 23 00 18 01 85 01 00 C0"), "585 60 00 18 01 " + ok);
  EXPECT_EQ(bench.answer("605 23 04 18 01 85 01 00 40"), "585 60 04 18 01 " + ok)
      << "TPDO5 on what TPDO1 had";
  EXPECT_EQ(bench.answer("605 23 00 18 01 80 00 00 C0"), "585 60 00 18 01 " + ok)
      << "what is off is nobody's";
}

TEST(Sdo, MapsAPdoByTheProcedureAndRefusesWhatDoesNotFit) {
  Bench bench;
  const std::string ok = "585 60 04 1A ";
  EXPECT_EQ(bench.answer("605 2F 04 1A 00 00 00 00 00"), ok + "00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 23 04 1A 01 20 02 50 21"), ok + "01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 23 04 1A 02 20 03 50 21"), ok + "02 00 00 00 00");
  EXPECT_EQ(bench.answer("605 23 04 1A 03 10 00 41 60"), ok + "03 00 00 00 00");
  EXPECT_EQ(bench.answer("605 23 04 1A 04 10 00 40 60"), ok + "04 00 00 00 00")
      << "an RPDO's object may be read back";
  EXPECT_EQ(bench.answer("605 23 04 1A 05 20 00 00 10"), "585 80 04 1A 05 41 00 04 06")
      << "1000h is not mappable";
  EXPECT_EQ(bench.answer("605 23 04 1A 05 20 00 00 50"), "585 80 04 1A 05 00 00 02 06") << "no object";
  EXPECT_EQ(bench.answer("605 23 04 1A 05 20 09 50 21"), "585 80 04 1A 05 11 00 09 06") << "no sub-index";
  EXPECT_EQ(bench.answer("605 23 04 1A 05 10 02 50 21"), "585 80 04 1A 05 43 00 04 06")
      << "16 bits of a REAL32";
  EXPECT_EQ(bench.answer("605 2F 04 1A 00 03 00 00 00"), "585 80 04 1A 00 42 00 04 06") << "80 bits";
  EXPECT_EQ(bench.answer("605 2F 04 1A 00 09 00 00 00"), "585 80 04 1A 00 42 00 04 06") << "nine objects";
  EXPECT_EQ(bench.answer("605 2F 04 1A 00 02 00 00 00"), ok + "00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 04 1A 00 00 00 00 00"), "585 4F 04 1A 00 02 00 00 00");
  EXPECT_EQ(bench.answer("605 40 04 1A 02 00 00 00 00"), "585 43 04 1A 02 20 03 50 21");
}

TEST(Sdo, RefusesToReceiveWhatCanOnlyBeSent) {
  Bench bench;
  bench.answer("605 23 03 14 01 05 05 00 80");
  bench.answer("605 2F 03 16 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 23 03 16 01 20 02 50 21"), "585 80 03 16 01 41 00 04 06");
}

}  // namespace
}  // namespace plenum::canopen
