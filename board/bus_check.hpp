// What is amiss with a CAN interface that has just been opened.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
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
    return fmt::format("can:{}: is down, expected one that is up (ip link set {} up)", name, name);
  if (bus.state() == ports::CanState::bus_off)
    return fmt::format("can:{}: is off the bus, expected one that takes part in it (wiring, bit rate)", name);
  return {};
}

/// Empty: it is the one that board.toml states, or the interface has none, as a vcan. A board at another rate hears nothing but errors,
/// and disturbs all others.
inline std::string bit_rate_trouble(std::optional<std::uint32_t> runs_bit_s, unsigned stated_kbit,
                                    const std::string& name) {
  if (!runs_bit_s || *runs_bit_s == stated_kbit * 1000U) return {};
  return fmt::format(
      "can:{}: runs at {:g} kbit/s, expected the {} of can.bit_rate_kbit (BitRate= of 80-can0.network)", name,
      *runs_bit_s / 1000.0, stated_kbit);
}

}  // namespace plenum::board
