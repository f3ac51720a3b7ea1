// A link over a CAN interface of this machine (SocketCAN), by the driver of the board.
#pragma once

#include <chrono>
#include <deque>

#include "board/drivers/socketcan.hpp"
#include "host-sim/client/link.hpp"

namespace plenum::host::client {

class CanLink final : public Link {
 public:
  /// Throws std::runtime_error when the interface cannot be opened.
  explicit CanLink(const std::string& interface);

  /// Throws std::runtime_error when kUnsent frames wait: nothing on the bus acknowledges them.
  void send(const CanFrame& frame) override;
  /// Throws std::runtime_error when the interface is down.
  std::optional<CanFrame> receive(double timeout_s) override;
  double now_s() const override;
  std::uint64_t lost() const override { return can_.lost(); }
  /// The kernel's, since 1970.
  std::optional<std::uint64_t> stamp_us() const override;
  /// As the kernel has it; a virtual interface has none.
  std::optional<std::uint32_t> bit_rate() const override;

  static constexpr std::size_t kUnsent = 1024;

 private:
  void flush();

  std::string interface_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  board::drivers::SocketCan can_;
  std::deque<CanFrame> unsent_;  ///< the device's queue was full: these go first
};

}  // namespace plenum::host::client
