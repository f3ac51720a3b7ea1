#include "board/reopened_bus.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace plenum::board {
namespace {

using ports::CanFrame;
using ports::CanState;

/// The cable behind an interface, and what the test sees of it.
struct Adapter {
  bool plugged = true;
  bool up = true;
  int opened = 0;
  int closed = 0;
  std::uint32_t lost = 0;
};

class FakeInterface final : public ports::CanBus {
 public:
  explicit FakeInterface(Adapter& adapter) : adapter_(adapter), number_(++adapter.opened) {
    if (!adapter.plugged) throw std::runtime_error("can:can0: no such interface");
  }
  ~FakeInterface() { ++adapter_.closed; }
  FakeInterface(const FakeInterface&) = delete;
  FakeInterface& operator=(const FakeInterface&) = delete;

  bool send(const CanFrame&) noexcept override {
    down_ = !adapter_.plugged || !adapter_.up;
    return !down_;
  }
  bool receive(CanFrame&) noexcept override { return !down_ && adapter_.up; }
  CanState state() const noexcept override { return CanState::error_passive; }
  std::uint32_t lost() const noexcept override { return adapter_.lost; }
  bool is_down() const noexcept { return down_; }
  int descriptor() const noexcept { return number_; }

 private:
  Adapter& adapter_;
  int number_;
  bool down_ = false;
};

class ReopenedBusTest : public testing::Test {
 protected:
  using Bus = ReopenedBus<FakeInterface>;

  Bus make() {
    return Bus([this] { return std::make_unique<FakeInterface>(adapter); });
  }
  /// Ticks, beside a thread that opens at once.
  static void tend(Bus& bus, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      if (!bus.tend()) continue;
      bus.open_anew();
      bus.tend();
    }
  }

  Adapter adapter;
  CanFrame frame;
};

TEST_F(ReopenedBusTest, AnInterfaceThatIsThereIsTheBus) {
  Bus bus = make();
  EXPECT_EQ(bus.state(), CanState::error_passive);
  EXPECT_TRUE(bus.send(frame));
  EXPECT_TRUE(bus.receive(frame));
  EXPECT_EQ(bus.descriptor(), 1);
  EXPECT_EQ(bus.trouble(), "");
  tend(bus, 1000);
  EXPECT_EQ(adapter.opened, 1);
}

TEST_F(ReopenedBusTest, OneThatWasNeverThereIsABusThatIsOffUntilItComes) {
  adapter.plugged = false;
  Bus bus = make();
  EXPECT_EQ(bus.trouble(), "can:can0: no such interface");
  EXPECT_EQ(bus.state(), CanState::bus_off);
  EXPECT_EQ(bus.descriptor(), -1);
  EXPECT_FALSE(bus.send(frame));
  EXPECT_FALSE(bus.receive(frame));
  adapter.plugged = true;
  tend(bus, Bus::kPause_ticks);
  EXPECT_TRUE(bus.send(frame));
  EXPECT_EQ(bus.state(), CanState::error_passive);
}

TEST_F(ReopenedBusTest, OneThatIsPulledOutIsOpenedAnewOnceASecondAndCountsAsOnWithTheFirstFrame) {
  Bus bus = make();
  adapter.plugged = false;
  EXPECT_FALSE(bus.send(frame));
  EXPECT_EQ(bus.state(), CanState::bus_off);
  tend(bus, Bus::kPause_ticks - 1);
  EXPECT_EQ(adapter.opened, 1);
  tend(bus, 1);
  EXPECT_EQ(adapter.opened, 2);
  tend(bus, Bus::kPause_ticks);
  EXPECT_EQ(adapter.opened, 3);
  adapter.plugged = true;
  tend(bus, Bus::kPause_ticks);
  EXPECT_EQ(bus.state(), CanState::bus_off) << "opened, and no frame has crossed it";
  EXPECT_TRUE(bus.receive(frame));
  EXPECT_EQ(bus.state(), CanState::error_passive);
  EXPECT_EQ(bus.descriptor(), 4);
}

TEST_F(ReopenedBusTest, NoTickClosesOrOpensAnInterfaceOrWaitsForTheThreadThatDoes) {
  Bus bus = make();
  bus.open_anew();
  EXPECT_EQ(adapter.opened, 1) << "nobody has asked for another";
  adapter.plugged = false;
  EXPECT_FALSE(bus.send(frame));
  int asked = 0;
  for (int i = 0; i < 10 * Bus::kPause_ticks; ++i) {
    if (bus.tend()) ++asked;
    EXPECT_EQ(bus.state(), CanState::bus_off);
  }
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(adapter.opened, 1);
  EXPECT_EQ(adapter.closed, 0);
  EXPECT_EQ(bus.descriptor(), -1);
  EXPECT_FALSE(bus.send(frame));
  EXPECT_FALSE(bus.receive(frame));
  adapter.plugged = true;
  bus.open_anew();
  EXPECT_EQ(adapter.opened, 2);
  EXPECT_EQ(adapter.closed, 1);
  EXPECT_EQ(bus.descriptor(), -1) << "from the next tick on";
  EXPECT_FALSE(bus.tend());
  EXPECT_EQ(bus.descriptor(), 2);
  EXPECT_TRUE(bus.send(frame));
}

TEST_F(ReopenedBusTest, AnInterfaceThatIsThereAndDownStaysOffHoweverOftenItIsOpened) {
  Bus bus = make();
  adapter.up = false;
  EXPECT_FALSE(bus.send(frame));
  for (int i = 0; i < 500; ++i) {
    tend(bus, 1);
    EXPECT_EQ(bus.state(), CanState::bus_off);
    EXPECT_FALSE(bus.send(frame));
  }
  adapter.up = true;
  EXPECT_TRUE(bus.send(frame));
  EXPECT_EQ(bus.state(), CanState::error_passive);
}

TEST_F(ReopenedBusTest, FramesLostAreCountedOverAllOpenings) {
  Bus bus = make();
  adapter.lost = 3;
  adapter.plugged = false;
  EXPECT_FALSE(bus.send(frame));
  tend(bus, Bus::kPause_ticks);
  EXPECT_EQ(bus.lost(), 3U);
  adapter.plugged = true;
  adapter.lost = 2;
  tend(bus, Bus::kPause_ticks);
  EXPECT_EQ(bus.lost(), 5U);
}

}  // namespace
}  // namespace plenum::board
