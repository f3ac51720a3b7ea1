#include "host-sim/ports/simulated_bus.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace plenum::host::ports {
namespace {

CanFrame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> data = {}) {
  CanFrame frame;
  frame.id = id;
  for (const std::uint8_t byte : data) frame.data[frame.length++] = byte;
  return frame;
}

std::vector<Delivery> run(SimulatedBus& bus, std::uint64_t time_ns) {
  std::vector<Delivery> deliveries;
  bus.run_until(time_ns, [&](const Delivery& delivery) { deliveries.push_back(delivery); });
  return deliveries;
}

std::vector<std::uint32_t> ids(const std::vector<Delivery>& deliveries) {
  std::vector<std::uint32_t> result;
  for (const Delivery& delivery : deliveries) result.push_back(delivery.frame.id);
  return result;
}

TEST(SimulatedBus, DeliversToEveryOtherNodeAtTheEndOfFrame) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  SimulatedCanPort& c = bus.attach("c");
  ASSERT_TRUE(a.send(frame_of(0)));  // 50 bits of 1 us, by hand in can_frame_bits_test.cpp
  CanFrame received;
  EXPECT_TRUE(run(bus, 49'999).empty());
  EXPECT_FALSE(b.receive(received));
  const std::vector<Delivery> deliveries = run(bus, 50'000);
  ASSERT_EQ(deliveries.size(), 1U);
  EXPECT_EQ(deliveries[0].end_ns, 50'000U);
  EXPECT_TRUE(b.receive(received));
  EXPECT_EQ(received, frame_of(0));
  EXPECT_TRUE(c.receive(received));
  EXPECT_FALSE(a.receive(received)) << "a node does not hear itself";
}

TEST(SimulatedBus, TakesTheBitTimeFromTheBitRate) {
  SimulatedBus bus({.bit_rate = 125'000});
  SimulatedCanPort& a = bus.attach("a");
  bus.attach("b");
  a.send(frame_of(0));
  const std::vector<Delivery> deliveries = run(bus, 1'000'000);
  ASSERT_EQ(deliveries.size(), 1U);
  EXPECT_EQ(deliveries[0].end_ns, 50U * 8'000U);
  EXPECT_THROW(SimulatedBus({.bit_rate = 300'007}), std::invalid_argument);
}

TEST(SimulatedBus, LetsTheLowestIdentifierWinAndKeepsThreeBitsBetweenFrames) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  SimulatedCanPort& c = bus.attach("c");
  a.send(frame_of(0x701, {5}));
  b.send(frame_of(0x181, {1, 2}));
  c.send(frame_of(0x080));
  const std::vector<Delivery> deliveries = run(bus, 1'000'000);
  EXPECT_EQ(ids(deliveries), (std::vector<std::uint32_t>{0x080, 0x181, 0x701}));
  ASSERT_EQ(deliveries.size(), 3U);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(deliveries[i].end_ns - deliveries[i - 1].end_ns, 1000U * (3U + deliveries[i].bits))
        << "frame " << i;
  }
}

TEST(SimulatedBus, DoesNotInterruptAFrameForAMoreUrgentOne) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  a.send(frame_of(0x7FF, {1, 2, 3, 4, 5, 6, 7, 8}));
  bus.run_until(20'000);
  b.send(frame_of(0x001));
  EXPECT_EQ(ids(run(bus, 1'000'000)), (std::vector<std::uint32_t>{0x7FF, 0x001}));
}

TEST(SimulatedBus, StartsNothingAtTheVeryTimeItRunsTo) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  bus.run_until(1'000);
  a.send(frame_of(0x7FF));
  bus.run_until(1'000);
  b.send(frame_of(0x001));  // queued at the same time, however often the bus was run in between
  EXPECT_EQ(ids(run(bus, 1'000'000)), (std::vector<std::uint32_t>{0x001, 0x7FF}));
}

TEST(SimulatedBus, SendsOneNodesFramesInTheOrderTheyWereQueued) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  bus.attach("b");
  a.send(frame_of(0x701));
  a.send(frame_of(0x081));
  EXPECT_EQ(ids(run(bus, 1'000'000)), (std::vector<std::uint32_t>{0x701, 0x081}));
}

TEST(SimulatedBus, HoldsALowPriorityFrameBackByExactlyTheFramesThatWin) {
  SimulatedBus bus;
  SimulatedCanPort& low = bus.attach("low");
  SimulatedCanPort& high = bus.attach("high");
  low.send(frame_of(0x7FF, {0x55}));
  for (int i = 0; i < 10; ++i) high.send(frame_of(0));
  const std::vector<Delivery> deliveries = run(bus, 10'000'000);
  ASSERT_EQ(deliveries.size(), 11U);
  EXPECT_EQ(deliveries.back().frame.id, 0x7FFU);
  const std::uint64_t expected_ns = 10U * 53U * 1000U + deliveries.back().bits * 1000U;
  EXPECT_EQ(bus.identifier_counters(0x7FF).worst_latency_ns, expected_ns);
  EXPECT_EQ(bus.identifier_counters(0).frames, 10U);
  EXPECT_EQ(bus.identifier_counters(0).worst_latency_ns, 9U * 53'000U + 50'000U);
}

TEST(SimulatedBus, CountsBitsAndItsBusyShare) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  bus.attach("b");
  a.send(frame_of(0));
  a.send(frame_of(0));
  bus.run_until(212'000);
  EXPECT_EQ(bus.counters().frames, 2U);
  EXPECT_EQ(bus.counters().bits, 2U * 53U);
  EXPECT_DOUBLE_EQ(bus.busy_share(), 0.5);
}

TEST(SimulatedBus, LetsAReceiverAnswerInTheVeryNextArbitration) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  a.send(frame_of(0x601));
  a.send(frame_of(0x602));
  std::vector<std::uint32_t> order;
  bus.run_until(1'000'000, [&](const Delivery& delivery) {
    order.push_back(delivery.frame.id);
    if (delivery.frame.id == 0x601) b.send(frame_of(0x581));
  });
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0x601, 0x581, 0x602}));
}

TEST(SimulatedBus, StopsAtTheNextDeliveryWhenAsked) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  bus.attach("b");
  a.send(frame_of(0));
  a.send(frame_of(0));
  EXPECT_TRUE(bus.run_to_next_delivery(1'000'000));
  EXPECT_EQ(bus.now_ns(), 50'000U);
  EXPECT_TRUE(bus.run_to_next_delivery(1'000'000));
  EXPECT_EQ(bus.now_ns(), 103'000U);
  EXPECT_FALSE(bus.run_to_next_delivery(1'000'000));
  EXPECT_EQ(bus.now_ns(), 1'000'000U);
}

TEST(SimulatedBus, RefusesFramesThatAreNoneAndAFullQueue) {
  SimulatedBus bus({.transmit_depth = 2});
  SimulatedCanPort& a = bus.attach("a");
  EXPECT_FALSE(a.send(frame_of(0x800)));
  CanFrame too_long = frame_of(1);
  too_long.length = 9;
  EXPECT_FALSE(a.send(too_long));
  EXPECT_TRUE(a.send(frame_of(1)));
  EXPECT_TRUE(a.send(frame_of(2)));
  EXPECT_FALSE(a.send(frame_of(3)));
  EXPECT_EQ(ids(run(bus, 1'000'000)), (std::vector<std::uint32_t>{1, 2}));
}

TEST(SimulatedBus, CountsWhatAFullReceiverLoses) {
  SimulatedBus bus({.receive_depth = 1});
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  a.send(frame_of(1));
  a.send(frame_of(2));
  bus.run_until(1'000'000);
  EXPECT_EQ(b.receive_overflows(), 1U);
  CanFrame frame;
  ASSERT_TRUE(b.receive(frame));
  EXPECT_EQ(frame.id, 1U) << "the older frame stays";
}

TEST(SimulatedBus, SilencesANodeThatIsBusOff) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  b.send(frame_of(5));
  b.set_state(CanState::bus_off);
  EXPECT_FALSE(b.send(frame_of(6)));
  a.send(frame_of(7));
  EXPECT_EQ(ids(run(bus, 1'000'000)), (std::vector<std::uint32_t>{7}));
  CanFrame frame;
  EXPECT_FALSE(b.receive(frame));
  b.set_state(CanState::error_active);
  EXPECT_TRUE(b.send(frame_of(6)));
  EXPECT_EQ(ids(run(bus, 2'000'000)), (std::vector<std::uint32_t>{6}));
}

TEST(SimulatedBus, DropsWhatItIsToldToAndStillSpendsTheTime) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  bus.drop_when([](const CanFrame& frame, std::size_t sender) { return sender == 0 && frame.id == 0; });
  a.send(frame_of(0));
  a.send(frame_of(1));
  const std::vector<Delivery> deliveries = run(bus, 1'000'000);
  ASSERT_EQ(deliveries.size(), 2U);
  EXPECT_TRUE(deliveries[0].dropped);
  CanFrame frame;
  ASSERT_TRUE(b.receive(frame));
  EXPECT_EQ(frame.id, 1U);
  EXPECT_FALSE(b.receive(frame));
  EXPECT_EQ(deliveries[1].end_ns, 53'000U + deliveries[1].bits * 1000U);
  EXPECT_EQ(bus.counters().dropped, 1U);
}

TEST(SimulatedBus, CountsTwoNodesThatShareAnIdentifier) {
  SimulatedBus bus;
  SimulatedCanPort& a = bus.attach("a");
  SimulatedCanPort& b = bus.attach("b");
  a.send(frame_of(0x181, {1}));
  b.send(frame_of(0x181, {2}));
  EXPECT_EQ(run(bus, 1'000'000).size(), 2U);
  EXPECT_EQ(bus.counters().collisions, 1U);
}

TEST(SimulatedBus, RefusesToRunBackwards) {
  SimulatedBus bus;
  bus.run_until(10);
  EXPECT_THROW(bus.run_until(9), std::logic_error);
}

struct Sending {
  std::uint64_t at_ns;
  std::size_t node;
  CanFrame frame;
};

std::vector<Delivery> replay(const std::vector<Sending>& script, std::uint64_t stride_ns,
                             std::uint64_t end_ns) {
  SimulatedBus bus;
  std::vector<SimulatedCanPort*> nodes;
  for (int i = 0; i < 4; ++i) nodes.push_back(&bus.attach("node"));
  std::vector<Delivery> deliveries;
  const auto collect = [&](const Delivery& delivery) { deliveries.push_back(delivery); };
  std::uint64_t next_stop = stride_ns;
  for (const Sending& sending : script) {
    for (; next_stop < sending.at_ns; next_stop += stride_ns) bus.run_until(next_stop, collect);
    bus.run_until(sending.at_ns, collect);
    EXPECT_TRUE(nodes[sending.node]->send(sending.frame));
  }
  bus.run_until(end_ns, collect);
  return deliveries;
}

RC_GTEST_PROP(SimulatedBus, GivesTheSameFramesWhateverTheStridesItIsRunIn, ()) {
  std::vector<Sending> script;
  std::uint64_t time_ns = 0;
  const int count = *rc::gen::inRange(1, 40);
  for (int i = 0; i < count; ++i) {
    time_ns += *rc::gen::inRange<std::uint64_t>(0, 200'000);
    script.push_back({time_ns, *rc::gen::inRange<std::size_t>(0, 4),
                      frame_of(*rc::gen::inRange<std::uint32_t>(0, 0x800), {static_cast<std::uint8_t>(i)})});
  }
  const std::uint64_t end_ns = time_ns + 10'000'000;
  const auto coarse = replay(script, 1'000'000'000, end_ns);
  const auto fine = replay(script, *rc::gen::inRange<std::uint64_t>(1'000, 100'000), end_ns);
  RC_ASSERT(coarse.size() == script.size());
  RC_ASSERT(fine.size() == coarse.size());
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    RC_ASSERT(coarse[i].frame == fine[i].frame);
    RC_ASSERT(coarse[i].end_ns == fine[i].end_ns);
    if (i == 0) continue;
    RC_ASSERT(coarse[i].end_ns >= coarse[i - 1].end_ns + 1000U * (coarse[i].bits + kIntermissionBits));
  }
}

}  // namespace
}  // namespace plenum::host::ports
