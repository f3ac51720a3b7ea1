// What of the SocketCAN driver can be held to without a CAN interface: the kernel's form of a frame, what error frames say,
// and the words when there is none; when a bus-off is over. Two sockets on a virtual interface where this machine has one named vcan0.
#include "board/drivers/socketcan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>

namespace plenum::board::drivers {
namespace {

using ::testing::HasSubstr;

bool has_can() {
  const int socket = ::socket(PF_CAN, SOCK_RAW, CAN_RAW);
  if (socket >= 0) ::close(socket);
  return socket >= 0;
}

std::string failure(const std::string& interface) {
  try {
    const SocketCan can(interface);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no failure";
}

can_frame error_frame(std::uint32_t kind, std::uint8_t controller = 0) {
  can_frame frame{};
  frame.can_id = CAN_ERR_FLAG | kind;
  frame.can_dlc = CAN_ERR_DLC;
  frame.data[1] = controller;
  return frame;
}

TEST(SocketCan, FramesBecomeTheKernelsAndBack) {
  for (const CanFrame& frame :
       {CanFrame{.id = 0x7FF, .length = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}}, CanFrame{.id = 0},
        CanFrame{.id = 0x1FFF'FFFF, .length = 1, .extended = true, .data = {9}},
        CanFrame{.id = 5, .extended = true}, CanFrame{.id = 0x701, .length = 1, .remote = true}}) {
    EXPECT_EQ(from_kernel(to_kernel(frame)), frame);
  }
}

TEST(SocketCan, TheKernelsFlagsStandAboveTheIdentifier) {
  EXPECT_EQ(to_kernel({.id = 0x181}).can_id, 0x181U);
  EXPECT_EQ(to_kernel({.id = 0x181, .extended = true}).can_id, 0x8000'0181U);
  EXPECT_EQ(to_kernel({.id = 0x181, .remote = true}).can_id, 0x4000'0181U);
  EXPECT_EQ(to_kernel({.id = 1, .length = 3}).can_dlc, 3);
}

/// As the kernel compares: can(7), "received_can_id & mask == can_id & mask".
bool lets_through(const CanFilter& filter, const CanFrame& frame) {
  const can_filter kernel = kernel_filter(filter);
  return (to_kernel(frame).can_id & kernel.can_mask) == (kernel.can_id & kernel.can_mask);
}

TEST(SocketCan, TheFilterOfANodeLetsEveryDataFrameOf11BitsThroughAndNoOther) {
  for (std::uint32_t id = 0; id <= CAN_SFF_MASK; ++id) {
    EXPECT_TRUE(lets_through(kBaseDataFrames, {.id = id})) << id;
    EXPECT_FALSE(lets_through(kBaseDataFrames, {.id = id, .remote = true})) << id;
    EXPECT_FALSE(lets_through(kBaseDataFrames, {.id = id, .extended = true})) << id;
  }
  EXPECT_FALSE(lets_through(kBaseDataFrames, {.id = CAN_EFF_MASK, .extended = true}));
}

TEST(SocketCan, AFilterComparesTheBitsOfItsMask) {
  const CanFilter only{.id = 0x180, .mask = 0x780};
  EXPECT_TRUE(lets_through(only, {.id = 0x1FF}));
  EXPECT_FALSE(lets_through(only, {.id = 0x200}));
  EXPECT_FALSE(lets_through(only, {.id = 0x181, .extended = true}));
  EXPECT_TRUE(lets_through({.id = 0x180, .mask = 0x780, .extended = true}, {.id = 0x1181, .extended = true}));
}

TEST(SocketCan, BytesBeyondTheLengthAreZero) {
  can_frame kernel{};
  kernel.can_dlc = 1;
  kernel.data[0] = 1;
  kernel.data[1] = 0xEE;
  EXPECT_EQ(from_kernel(kernel), (CanFrame{.length = 1, .data = {1}}));
}

TEST(SocketCan, ErrorFramesAreNoFramesButSayTheControllersState) {
  EXPECT_EQ(from_kernel(error_frame(CAN_ERR_BUSOFF)), std::nullopt);
  EXPECT_EQ(state_in(error_frame(CAN_ERR_BUSOFF)), CanState::bus_off);
  EXPECT_EQ(state_in(error_frame(CAN_ERR_RESTARTED)), CanState::error_active);
  EXPECT_EQ(state_in(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE)), CanState::error_passive);
  EXPECT_EQ(state_in(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE)), CanState::error_passive);
  EXPECT_EQ(state_in(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE)), CanState::error_active);
  EXPECT_EQ(state_in(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING)), CanState::error_active);
  EXPECT_EQ(state_in(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW)), std::nullopt);
  EXPECT_EQ(state_in(error_frame(CAN_ERR_PROT)), std::nullopt);
  EXPECT_EQ(state_in(to_kernel({.id = CAN_ERR_BUSOFF})), std::nullopt);
}

constexpr ControllerState::Time kStart{std::chrono::hours(1)};

TEST(ControllerState, IsWhatWasToldOfItLast) {
  ControllerState controller;
  EXPECT_EQ(controller.state(), CanState::error_active);
  controller.hear(CanState::error_passive, kStart);
  EXPECT_EQ(controller.state(), CanState::error_passive);
  EXPECT_FALSE(controller.may_be_on_again(ControllerState::Time::max()))
      << "the kernel is asked while on the bus";
}

TEST(ControllerState, ABusOffThatNobodyHasEndedIsNotAskedFor) {
  ControllerState controller;
  controller.hear(CanState::bus_off, kStart);
  EXPECT_EQ(controller.state(), CanState::bus_off);
  EXPECT_FALSE(controller.may_be_on_again(kStart + std::chrono::hours(1)));
}

TEST(ControllerState, ABusOffLastsUntilTheInterfaceRunsSomeTimeAfterItsEndWasTold) {
  ControllerState controller;
  controller.hear(CanState::bus_off, kStart);
  const auto told = kStart + std::chrono::milliseconds(100);
  controller.hear(CanState::error_active, told);
  EXPECT_EQ(controller.state(), CanState::bus_off);
  EXPECT_FALSE(controller.may_be_on_again(told + ControllerState::kSettling - std::chrono::nanoseconds(1)));
  EXPECT_TRUE(controller.may_be_on_again(told + ControllerState::kSettling));
  EXPECT_EQ(controller.state(), CanState::bus_off) << "the interface does not run yet";
  controller.on_again();
  EXPECT_EQ(controller.state(), CanState::error_active);
}

TEST(ControllerState, WhatIsToldAfterTheEndOfABusOffDoesNotPutItOff) {
  ControllerState controller;
  controller.hear(CanState::bus_off, kStart);
  controller.hear(CanState::error_active, kStart);
  controller.hear(CanState::error_passive, kStart + ControllerState::kSettling / 2);
  EXPECT_TRUE(controller.may_be_on_again(kStart + ControllerState::kSettling));
  controller.on_again();
  EXPECT_EQ(controller.state(), CanState::error_passive);
}

TEST(ControllerState, ABusOffRightAfterTheEndOfAnotherIsAnother) {
  ControllerState controller;
  controller.hear(CanState::bus_off, kStart);
  controller.hear(CanState::error_active, kStart);
  controller.hear(CanState::bus_off, kStart);
  EXPECT_FALSE(controller.may_be_on_again(kStart + std::chrono::hours(1)));
}

TEST(ControllerState, OneThatWasFoundOffMayBeOnWithoutAWordOfItButNotAtOnce) {
  ControllerState controller;
  controller.found_off(kStart);
  EXPECT_EQ(controller.state(), CanState::bus_off);
  EXPECT_FALSE(controller.may_be_on_again(kStart + std::chrono::seconds(1)));
  EXPECT_TRUE(controller.may_be_on_again(kStart + ControllerState::kStale));
}

TEST(ControllerState, OneThatWasFoundOffIsOnSoonAfterItsRestart) {
  ControllerState controller;
  controller.found_off(kStart);
  controller.hear(CanState::error_active, kStart);
  EXPECT_TRUE(controller.may_be_on_again(kStart + ControllerState::kSettling));
}

TEST(SocketCan, AKernelWithoutCanIsToldAsThat) {
  if (has_can()) GTEST_SKIP() << "this kernel has AF_CAN";
  EXPECT_EQ(
      failure("can0"),
      "can:can0: no AF_CAN in this kernel, expected one with the modules can and can_raw (modprobe can_raw)");
}

TEST(SocketCan, AnInterfaceThatIsNoneIsToldByItsName) {
  if (!has_can()) GTEST_SKIP() << "no AF_CAN in this kernel";
  EXPECT_THAT(failure("nocan9"), HasSubstr("can:nocan9: no such interface"));
  EXPECT_THAT(failure(""), HasSubstr("no name of an interface"));
  EXPECT_THAT(failure("lo"), HasSubstr("expected a CAN interface"));
}

TEST(SocketCan, TwoSocketsOnAVirtualInterfaceHearEachOtherThroughTheirFilters) {
  if (failure("vcan0") != "no failure") GTEST_SKIP() << failure("vcan0");
  SocketCan sender("vcan0");
  const CanFilter only{.id = 0x180, .mask = 0x780};
  SocketCan receiver("vcan0", {&only, 1});
  const CanFrame wanted{.id = 0x181, .length = 2, .data = {1, 2}};
  ASSERT_TRUE(sender.send({.id = 0x201}));
  ASSERT_TRUE(sender.send({.id = 0x181, .extended = true}));
  ASSERT_TRUE(sender.send(wanted));
  pollfd waiting{receiver.descriptor(), POLLIN, 0};
  ASSERT_EQ(::poll(&waiting, 1, 5000), 1);
  CanFrame frame;
  ASSERT_TRUE(receiver.receive(frame));
  EXPECT_EQ(frame, wanted);
  EXPECT_GT(receiver.received_ns(), 0U);
  EXPECT_FALSE(receiver.receive(frame));
}

}  // namespace
}  // namespace plenum::board::drivers
