// CAN through the kernel's SocketCAN: the driver of the board, and the PC's door to a real bus.
//
// Sending never waits. A queue of the network device that is full (ENOBUFS) leaves the frame with the caller, who offers it
// again. Receiving takes what waits. Filters are the kernel's: a frame that none of them lets through wakes nobody.
//
// Bus-off: the driver reports it, and reports error-active again when the kernel has restarted the controller. Restarting is
// the interface's policy, not the program's: `ip link set can0 type can restart-ms 100`; without it a controller stays off the
// bus until someone restarts it.
#pragma once

#include <linux/can.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "firmware/ports/can_bus.hpp"

namespace plenum::board::drivers {

using ports::CanFrame;
using ports::CanState;

/// Lets a data frame through when its identifier and this one agree in the bits of `mask`, and in their length. No remote frame.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;  ///< 0: all of them
  bool extended = false;
};

class SocketCan final : public ports::CanBus {
 public:
  /// Opens `interface` ("can0"); without filters every frame comes. Throws std::runtime_error: what, where, expected.
  explicit SocketCan(const std::string& interface, std::span<const CanFilter> filters = {});
  ~SocketCan();
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  /// False when the queue is full, the interface is down or gone, or the frame is none.
  bool send(const CanFrame& frame) noexcept override;
  bool receive(CanFrame& frame) noexcept override;
  CanState state() const noexcept override { return state_; }
  std::uint32_t lost() const noexcept override { return lost_; }

  /// When the kernel took the last received frame from the controller [ns since the epoch]; 0 before the first.
  std::uint64_t received_ns() const noexcept { return received_ns_; }
  /// The interface went down or away: nothing more will come until it is opened again.
  bool is_down() const noexcept { return down_; }
  /// To wait on.
  int descriptor() const noexcept { return socket_; }

 private:
  int socket_ = -1;
  CanState state_ = CanState::error_active;
  std::uint32_t lost_ = 0;
  std::uint64_t received_ns_ = 0;
  bool down_ = false;
};

/// Every data frame of 11 bits: all that canopen::Node takes, whatever its PDOs and its SYNC are set to.
inline constexpr CanFilter kBaseDataFrames{};

can_filter kernel_filter(const CanFilter& filter) noexcept;
/// The kernel's form of a frame. `length` up to 8.
can_frame to_kernel(const CanFrame& frame) noexcept;
/// Empty for an error frame.
std::optional<CanFrame> from_kernel(const can_frame& frame) noexcept;
/// What an error frame says of the controller's state; empty when it says nothing of it.
std::optional<CanState> state_in(const can_frame& error_frame) noexcept;

}  // namespace plenum::board::drivers
