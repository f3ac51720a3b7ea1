// What is amiss with a CAN interface that has just been opened.
#pragma once

#include <fmt/format.h>

#include <string>

#include "firmware/ports/can_bus.hpp"

namespace plenum::board {

/// Empty: nothing. The kernel opens an interface that is down without a word, and says so to the first who wants to receive.
/// `Interface` is a ports::CanBus with is_down(), as drivers::SocketCan is; `name` is its own.
template <class Interface>
std::string trouble_of(Interface& bus, const std::string& name) {
  ports::CanFrame frame;
  bus.receive(frame);
  if (bus.is_down())
    return fmt::format("can:{}: is down, expected one that is up (systemctl start plenumd-bus)", name);
  if (bus.state() == ports::CanState::bus_off)
    return fmt::format("can:{}: is off the bus, expected one that takes part in it (wiring, bit rate)", name);
  return {};
}

}  // namespace plenum::board
