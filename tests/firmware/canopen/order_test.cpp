// A write that waits for the parameter store: its answer is withheld, and the transfer always ends.
#include <gtest/gtest.h>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

constexpr const char* kStoreAll = "605 23 10 10 01 73 61 76 65";  // "save"

struct Waiting : Bench {
  Waiting() {
    answer("605 2B 17 10 00 00 00 00 00");  // no heartbeat in between
    EXPECT_EQ(answer(kStoreAll), "") << "the answer is withheld";
  }
  void finish(Abort result) {
    node.order().result = result;
    node.order().done = true;
    tick();
  }
};

TEST(StoreOrder, IsAnsweredWhenItIsDone) {
  Waiting bench;
  EXPECT_EQ(bench.node.order().what, StoreOrder::What::store);
  EXPECT_EQ(bench.node.order().sub, 1);
  bench.tick(50);
  EXPECT_EQ(bench.drain(), Frames{});
  bench.finish(Abort::none);
  EXPECT_EQ(bench.drain(), Frames{"585 60 10 10 01 00 00 00 00"});
  EXPECT_EQ(bench.node.order().what, StoreOrder::What::none);
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF");
}

TEST(StoreOrder, IsAnsweredWithTheReasonWhenTheStoreFails) {
  Waiting bench;
  bench.finish(Abort::hardware_error);
  EXPECT_EQ(bench.drain(), Frames{"585 80 10 10 01 00 00 06 06"});
  EXPECT_EQ(bench.answer(kStoreAll), "") << "a new order may be given";
}

TEST(StoreOrder, IsAnsweredAsASegmentWhenASegmentGaveIt) {
  Bench bench;
  bench.answer("605 2B 17 10 00 00 00 00 00");
  EXPECT_EQ(bench.answer("605 21 10 10 01 04 00 00 00"), "585 60 10 10 01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 07 73 61 76 65 00 00 00"), "");
  bench.node.order().done = true;
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"585 20 00 00 00 00 00 00 00"});
}

TEST(StoreOrder, RefusesAllElseMeanwhileAndIsAnsweredAllTheSame) {
  Waiting bench;
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 80 00 10 00 22 00 00 08");
  EXPECT_EQ(bench.answer("605 2B 40 60 00 07 00 00 00"), "585 80 40 60 00 22 00 00 08");
  EXPECT_EQ(bench.answer(kStoreAll), "585 80 10 10 01 22 00 00 08");
  EXPECT_EQ(bench.image.control_word, 0);
  bench.finish(Abort::none);
  EXPECT_EQ(bench.drain(), Frames{"585 60 10 10 01 00 00 00 00"});
}

TEST(StoreOrder, IsNotRefusedBecauseItsFrameComesTwice) {
  Waiting bench;
  EXPECT_EQ(bench.answer(kStoreAll), "") << "as CAN repeats a frame";
  bench.finish(Abort::none);
  EXPECT_EQ(bench.drain(), Frames{"585 60 10 10 01 00 00 00 00"});
  EXPECT_EQ(bench.answer(kStoreAll), "") << "a new order";
  bench.tick();
  EXPECT_EQ(bench.answer(kStoreAll), "585 80 10 10 01 22 00 00 08") << "a tick later it is another master's";
}

TEST(StoreOrder, StandsWhenItsClientHasGivenUp) {
  Waiting bench;
  EXPECT_EQ(bench.answer("605 80 10 10 01 00 00 04 05"), "");
  EXPECT_EQ(bench.answer("605 40 00 10 00 00 00 00 00"), "585 43 00 10 00 98 01 FF FF");
  EXPECT_EQ(bench.answer(kStoreAll), "585 80 10 10 01 22 00 00 08") << "one order at a time";
  bench.finish(Abort::none);
  EXPECT_EQ(bench.drain(), Frames{}) << "nobody waits";
  EXPECT_EQ(bench.answer(kStoreAll), "");
}

TEST(StoreOrder, DoesNotHangOnAStoreThatNeverEnds) {
  Waiting bench;
  bench.tick(499);
  EXPECT_EQ(bench.drain(), Frames{});
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"585 80 10 10 01 00 00 04 05"}) << "after 5 s";
  bench.finish(Abort::none);
  EXPECT_EQ(bench.drain(), Frames{});
  EXPECT_EQ(bench.answer(kStoreAll), "");
}

TEST(StoreOrder, IsTakenAwayWhenItIsDoneInEveryStateOfTheNode) {
  const std::vector<Frames> ways = {
      {"000 80 05"},
      {"000 01 05"},
      {"000 02 05"},
      {"7E5 04 01 00 00 00 00 00 00", "7E5 11 FF 00 00 00 00 00 00", "000 82 05"}};  // without a node id
  for (const Frames& way : ways) {
    Waiting bench;
    for (const std::string& frame : way) bench.send(frame);
    bench.finish(Abort::none);
    EXPECT_EQ(bench.node.order().what, StoreOrder::What::none) << way.back();
  }
}

TEST(StoreOrder, IsNotAnsweredInStopped) {
  Waiting bench;
  bench.send("000 02 05");
  bench.finish(Abort::none);
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{});
}

TEST(StoreOrder, OutlivesAResetOfTheCommunication) {
  Waiting bench;
  bench.send("000 82 05");
  bench.tick();
  EXPECT_EQ(bench.drain(), Frames{"705 00"});
  bench.answer("605 2B 17 10 00 00 00 00 00");
  EXPECT_EQ(bench.node.order().what, StoreOrder::What::store);
  bench.finish(Abort::none);
  EXPECT_EQ(bench.drain(), Frames{});
}

}  // namespace
}  // namespace plenum::canopen
