// The way from a PC program to a CAN bus: simulated, socketcand or SocketCAN.
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/ports/can_bus.hpp"

namespace plenum::host::client {

using plenum::ports::CanFrame;

class Link {
 public:
  virtual ~Link() = default;

  /// Queues a frame, waiting for room as long as the bus takes others. Throws std::runtime_error when it cannot be
  /// queued.
  virtual void send(const CanFrame& frame) = 0;
  /// The next frame that anybody else sent. Waits for it up to `timeout_s`; a simulated link runs its world
  /// meanwhile. Empty when none came; with a time-out of 0 only what is already there is taken.
  virtual std::optional<CanFrame> receive(double timeout_s) = 0;
  /// Time of this link's world [s]: monotonic, any origin.
  virtual double now_s() const = 0;
  /// Frames that had no room where they wait for receive(), since the link was opened: as far as the frames received so far tell.
  /// 0, too, where the link cannot know.
  virtual std::uint64_t lost() const { return 0; }
  /// When the frame that receive() returned last was on the bus, by whoever took it from there (kernel, socketcand server) [us since an
  /// epoch of its own]; empty where the link does not learn of it.
  virtual std::optional<std::uint64_t> stamp_us() const { return std::nullopt; }
  /// Of the bus [bit/s]; empty where the link cannot know.
  virtual std::optional<std::uint32_t> bit_rate() const { return std::nullopt; }
};

}  // namespace plenum::host::client
