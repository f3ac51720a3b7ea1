#include "board/bus_check.hpp"

#include <gtest/gtest.h>

namespace plenum::board {
namespace {

using ports::CanFrame;
using ports::CanState;

/// As the kernel has it: nothing is said of an interface that is down before someone wants to receive.
class OpenedInterface final : public ports::CanBus {
 public:
  OpenedInterface(bool up, CanState state) : up_(up), state_(state) {}

  bool send(const CanFrame&) noexcept override { return sent = true; }
  bool receive(CanFrame&) noexcept override {
    down_ = !up_;
    return false;
  }
  CanState state() const noexcept override { return state_; }
  std::uint32_t lost() const noexcept override { return 0; }
  bool is_down() const noexcept { return down_; }

  bool sent = false;

 private:
  bool up_;
  CanState state_;
  bool down_ = false;
};

TEST(BusCheck, AnInterfaceThatIsDownIsToldByItsName) {
  OpenedInterface bus(false, CanState::error_active);
  EXPECT_EQ(trouble_of(bus, "can0"),
            "can:can0: is down, expected one that is up (systemctl start plenumd-bus)");
}

TEST(BusCheck, AControllerOffTheBusIsToldByItsName) {
  OpenedInterface bus(true, CanState::bus_off);
  EXPECT_EQ(trouble_of(bus, "can0"),
            "can:can0: is off the bus, expected one that takes part in it (wiring, bit rate)");
}

TEST(BusCheck, OneThatTakesPartIsWellAndHearsNothingFromTheCheck) {
  for (const CanState state : {CanState::error_active, CanState::error_passive}) {
    OpenedInterface bus(true, state);
    EXPECT_EQ(trouble_of(bus, "can0"), "");
    EXPECT_FALSE(bus.sent);
  }
}

}  // namespace
}  // namespace plenum::board
