// CAN, as the core sees it: classic frames in and out, and the state of the controller. No OS, no blocking.
#pragma once

#include <array>
#include <cstdint>

namespace plenum::ports {

/// A classic CAN 2.0 data or remote frame.
struct CanFrame {
  std::uint32_t id = 0;                           ///< 11 bits, or 29 when `extended`
  std::uint8_t length = 0;                        ///< data length code, 0..8
  bool extended = false;                          ///< 29-bit identifier
  bool remote = false;                            ///< remote transmission request (no data on the wire)
  alignas(4) std::array<std::uint8_t, 8> data{};  ///< bytes beyond `length` are zero; copied by words

  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

/// CAN 2.0 fault confinement states.
enum class CanState : std::uint8_t { error_active, error_passive, bus_off };

/// A CAN controller with a transmit queue. Implementations: board/drivers (SocketCAN), host-sim/ports
/// (simulated bus).
class CanBus {
 public:
  /// Queues a frame for transmission. Returns false, leaving the queue as it was, when the queue is full.
  virtual bool send(const CanFrame& frame) noexcept = 0;
  /// Takes the oldest received frame. Returns false when none is waiting.
  virtual bool receive(CanFrame& frame) noexcept = 0;
  virtual CanState state() const noexcept = 0;
  /// Frames lost because the receive queue was full, since the start; wraps.
  virtual std::uint32_t lost() const noexcept = 0;

 protected:
  ~CanBus() = default;
};

}  // namespace plenum::ports
