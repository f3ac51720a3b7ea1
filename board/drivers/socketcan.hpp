// CAN through the kernel's SocketCAN: the driver of the board, and the PC's door to a real bus.
//
// Sending never waits. A queue of the network device that is full (ENOBUFS) leaves the frame with the caller, who offers it
// again. Receiving takes what waits. Filters are the kernel's: a frame that none of them lets through wakes nobody.
//
// Bus-off: the driver reports it and takes no frame, until the kernel has restarted the controller and sends again. Restarting is
// the interface's policy, not the program's: `ip link set can0 type can restart-ms 100`; without it a controller stays off the
// bus until someone restarts it.
#pragma once

#include <linux/can.h>

#include <chrono>
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

/// A controller's state by what the kernel tells of it. The kernel tells that a bus-off is over before it is, and until the interface runs
/// again takes frames and drops them without a word. So it is to be asked, and not too soon.
class ControllerState {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A tick, and more than the kernel takes from telling of a restart to its end.
  static constexpr std::chrono::milliseconds kSettling{10};
  /// More than the second within which the kernel says of an interface whose carrier has gone that it does not run (its link_watch.c).
  static constexpr std::chrono::milliseconds kStale{1100};

  /// By an error frame, or by what proves it.
  void hear(CanState told, Time now) noexcept;
  /// It was off the bus before anyone listened.
  void found_off(Time now) noexcept;

  /// Whether to ask if the interface runs; if it does, on_again().
  bool may_be_on_again(Time now) const noexcept { return off_ && now >= ask_from_; }
  void on_again() noexcept { off_ = false; }

  CanState state() const noexcept { return off_ ? CanState::bus_off : told_; }

 private:
  CanState told_ = CanState::error_active;
  bool off_ = false;
  Time ask_from_;  ///< whether the interface runs
};

class SocketCan final : public ports::CanBus {
 public:
  /// Opens `interface` ("can0"); without filters every frame comes. Throws std::runtime_error: what, where, expected.
  explicit SocketCan(const std::string& interface, std::span<const CanFilter> filters = {});
  ~SocketCan();
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  /// False when the queue is full, the controller is off the bus, the interface is down or gone, or the frame is none.
  bool send(const CanFrame& frame) noexcept override;
  bool receive(CanFrame& frame) noexcept override;
  CanState state() const noexcept override { return controller_.state(); }
  std::uint32_t lost() const noexcept override { return lost_; }

  /// When the kernel took the last received frame from the controller [ns since the epoch]; 0 before the first.
  std::uint64_t received_ns() const noexcept { return received_ns_; }
  /// The interface went down or away: nothing comes, nor what had come before, until it is up again or opened anew.
  bool is_down() const noexcept { return down_; }
  /// To wait on.
  int descriptor() const noexcept { return socket_; }

 private:
  void go_down() noexcept;
  bool runs() const noexcept;
  void end_bus_off() noexcept;

  std::string interface_;
  int socket_ = -1;
  ControllerState controller_;
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
