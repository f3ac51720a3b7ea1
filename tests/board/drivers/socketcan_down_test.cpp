// The driver of SocketCAN as its interface goes down, where this machine has no CAN: a pair of local sockets stands for the raw socket
// and the wire. The kernel's order is net/can/raw.c's: who reads is told first that the interface has gone down, by an error that
// is told once, and then gets what had come before.
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "board/drivers/socketcan.hpp"

namespace plenum::board::drivers {
namespace {

struct Kernel {
  int raw = -1;   ///< the driver's socket
  int wire = -1;  ///< the other end
  int error = 0;  ///< of the socket, told once
};
Kernel kernel;

/// Whether an error was told instead.
bool tells_error(int file) noexcept {
  if (file != kernel.raw || kernel.error == 0) return false;
  errno = std::exchange(kernel.error, 0);
  return true;
}

}  // namespace
}  // namespace plenum::board::drivers

// In the place of the C library's.
extern "C" {
int socket(int domain, int type, int protocol) noexcept {
  if (domain != PF_CAN) return static_cast<int>(::syscall(SYS_socket, domain, type, protocol));
  int ends[2] = {-1, -1};
  if (::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0) return -1;
  plenum::board::drivers::kernel = {.raw = ends[0], .wire = ends[1]};
  return ends[0];
}
int bind(int, const sockaddr*, socklen_t) noexcept {
  return 0;
}
int setsockopt(int, int, int, const void*, socklen_t) noexcept {
  return 0;
}
unsigned if_nametoindex(const char*) noexcept {
  return 1;
}
ssize_t recvmsg(int file, msghdr* message, int flags) {
  return plenum::board::drivers::tells_error(file) ? -1 : ::syscall(SYS_recvmsg, file, message, flags);
}
ssize_t write(int file, const void* bytes, size_t size) {
  return plenum::board::drivers::tells_error(file) ? -1 : ::syscall(SYS_write, file, bytes, size);
}
}

namespace plenum::board::drivers {
namespace {

class SocketCanDownTest : public testing::Test {
 protected:
  ~SocketCanDownTest() override { ::close(kernel.wire); }

  static void bring(std::uint32_t id) {
    const can_frame one = to_kernel({.id = id, .length = 1});
    ASSERT_EQ(::send(kernel.wire, &one, sizeof one, 0), static_cast<ssize_t>(sizeof one));
  }
  void expect_nothing_until_it_is_up_again() {
    for (int i = 0; i < 4; ++i) {
      EXPECT_FALSE(can.receive(frame)) << "an order of before: " << std::hex << frame.id;
      EXPECT_TRUE(can.is_down());
    }
    bring(0x83);
    EXPECT_TRUE(can.receive(frame));
    EXPECT_EQ(frame.id, 0x83U);
    EXPECT_FALSE(can.is_down());
  }

  SocketCan can{"can0"};
  CanFrame frame;
};

TEST_F(SocketCanDownTest, WhatHadComeBeforeIsNoSignOfLifeAndNoOrder) {
  for (const std::uint32_t id : {0x80U, 0x81U, 0x82U}) bring(id);
  kernel.error = ENETDOWN;
  expect_nothing_until_it_is_up_again();
}

TEST_F(SocketCanDownTest, NorIsItWhereASenderIsTheFirstToBeTold) {
  for (const std::uint32_t id : {0x80U, 0x81U, 0x82U}) bring(id);
  kernel.error = ENETDOWN;
  EXPECT_FALSE(can.send({.id = 1}));
  expect_nothing_until_it_is_up_again();
}

}  // namespace
}  // namespace plenum::board::drivers
