// The LSS master against a board on a simulated bus.
#include "host-sim/client/lss_master.hpp"

#include <gtest/gtest.h>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/client/errors.hpp"
#include "host-sim/client/session.hpp"
#include "tests/client/board_on_bus.hpp"

namespace plenum::host::client {
namespace {

const Identity kBoard{.vendor_id = 1, .product_code = 2, .revision = canopen::dictionary_revision()};

TEST(LssMaster, FindsTheBoardThatHasNoNodeIdAndNamesIt) {
  BoardOnBus world(canopen::kUnconfiguredNodeId);
  {
    LssMaster lss(world);
    const auto found = lss.find_unconfigured();
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(found->vendor_id, 1U);
    EXPECT_EQ(found->product_code, 2U);
    EXPECT_EQ(found->revision, canopen::dictionary_revision()) << "stated by nobody";
    EXPECT_EQ(found->serial, 0U);
    lss.give_node_id(9);
  }
  Session session(world, 9);
  EXPECT_EQ(session.wait_heartbeat(1.0), canopen::NmtState::initialising);
  EXPECT_EQ(session.read<std::uint32_t>(0x1018, 2), 2U);
}

/// A board on the bus of another world, which hears and answers at ticks alone, after the other has.
class Beside {
 public:
  Beside(BoardOnBus& world, std::uint8_t node_id, std::uint32_t serial)
      : port_(world.bus.attach("beside")),
        node_(canopen::Config{.node_id = node_id,
                              .identity = {.vendor_id = 1, .product_code = 2, .serial = serial}},
              image_, slots_, settings_, recorder_) {
    world.each_tick = [this] {
      for (CanFrame frame; port_.receive(frame);) node_.receive(frame);
      node_.tick(static_cast<std::uint32_t>(BoardOnBus::kTick_ns / 1000));
      for (CanFrame frame; node_.next_frame(frame);) port_.send(frame);
    };
  }

 private:
  ports::SimulatedCanPort& port_;
  canopen::ProcessImage image_;
  config::ParameterSlots slots_;
  config::SettingsDesk settings_;
  telemetry::Recorder recorder_;
  canopen::Node node_;
};

TEST(LssMaster, TellsBoardsWithoutANodeIdApartByTheirIdentity) {
  BoardOnBus world(canopen::kUnconfiguredNodeId);  // of serial number 0
  const Beside other(world, canopen::kUnconfiguredNodeId, 3);
  const auto name_next = [&world](std::uint8_t node_id) {
    LssMaster lss(world);
    const std::optional<Identity> found = lss.find_unconfigured();
    if (found) lss.give_node_id(node_id);
    return found ? static_cast<int>(found->serial) : -1;
  };
  EXPECT_EQ(name_next(8), 0);
  EXPECT_EQ(name_next(9), 3);
  EXPECT_EQ(name_next(10), -1);
  EXPECT_EQ(Session(world, 9).read<std::uint32_t>(0x1018, 4), 3U);
}

TEST(LssMaster, FindsNoBoardWhereAllHaveTheirNodeId) {
  BoardOnBus world;
  EXPECT_FALSE(LssMaster(world).find_unconfigured().has_value());
}

TEST(LssMaster, GivesTheBoardOfAnIdentityAnotherNodeIdFromItsResetOn) {
  BoardOnBus world(5);
  {
    LssMaster lss(world);
    lss.select(kBoard);
    lss.give_node_id(6);
  }
  Session(world, 5).nmt(canopen::NmtCommand::reset_communication);
  EXPECT_EQ(Session(world, 6).wait_heartbeat(1.0), canopen::NmtState::initialising);
}

TEST(LssMaster, ABoardOfAnotherIdentityDoesNotAnswer) {
  BoardOnBus world;
  LssMaster lss(world);
  EXPECT_THROW(lss.select({.vendor_id = 1, .product_code = 3}), Timeout);
  EXPECT_THROW(lss.give_node_id(7), Timeout) << "none is in the state of configuration";
}

TEST(LssMaster, TellsWhatABoardRefuses) {
  BoardOnBus world;
  LssMaster lss(world);
  lss.select(kBoard);
  EXPECT_THROW(lss.give_node_id(128), Refused);
  EXPECT_THROW(lss.give_bit_rate(123'456), std::invalid_argument);
  EXPECT_NO_THROW(lss.give_bit_rate(500'000));
}

TEST(LssMaster, LeavesNoBoardInConfiguration) {
  BoardOnBus world;
  { LssMaster(world).select(kBoard); }
  LssMaster another(world);
  EXPECT_THROW(another.give_node_id(7), Timeout);
}

}  // namespace
}  // namespace plenum::host::client
