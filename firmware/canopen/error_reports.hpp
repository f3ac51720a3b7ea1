// What a node says of its errors: the emergency message and the history 1003h.
//
// The most urgent error is told when it changes, also to none. Every other fault is told once when it has risen, behind it, and
// then the most urgent again: the last message is always of what 604Eh shows. So is the newest entry of 1003h when it has come.
// What finds the ring full is told in a later tick, unless it has gone by then. A fault that clears by itself is told once while a
// more urgent one stands, however often it comes: it may flicker.
//
// A lost heartbeat (8130h) has the node that fell silent in byte 4, and is told again for each other one that does while it stands.
//
// Source: CiA 301, 7.2.7 (emergency object), 7.5.2.4 (pre-defined error field).
#pragma once

#include <cstdint>

#include "firmware/canopen/communication.hpp"
#include "firmware/canopen/transmit_queue.hpp"

namespace plenum::canopen {

class ErrorReports {
 public:
  /// Once a tick in which the node may speak.
  void step(Device& device, TransmitQueue& queue) noexcept;

  /// A master that has just heard of the node knows of no error that stands.
  void tell_again() noexcept { untold_ = true; }

  static constexpr int kMostATick = 8;  ///< of the less urgent ones

 private:
  bool tell(const ErrorState& error, Device& device, TransmitQueue& queue) noexcept;
  bool tell_others(std::uint8_t error_register, Device& device, TransmitQueue& queue) noexcept;

  StandingFaults told_{};         ///< of those that stand
  ErrorState reported_;           ///< the error of the last message
  bool off_bus_ = false;          ///< as of the last report
  std::uint8_t told_silent_ = 0;  ///< nodes of 1016h, bit i its entry i, that 8130h has named since it stands
  bool untold_ = false;  ///< the most urgent: its message may have been lost with the bus, or is not the last
};

}  // namespace plenum::canopen
