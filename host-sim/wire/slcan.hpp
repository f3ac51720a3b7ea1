// The text of serial CAN adapters ("slcan", LAWICEL's): frames as lines that end in a carriage return.
//
//   t1812AB01    t 11-bit identifier, length, bytes         r1812   the same as a remote frame, without bytes
//   T000001810   T 29-bit identifier                        R...    29-bit remote
//
// To the adapter: S0..S8 sets the bit rate, O opens the bus, C closes it. It answers with a carriage return (a frame taken:
// z or Z before it), or with a bell when it refuses. Received frames may end in a four-digit time stamp, which is passed
// over. Source: LAWICEL CANUSB manual, chapter 2; Documentation/networking/can of Linux, slcan.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/ports/can_bus.hpp"

namespace plenum::host::wire {

using plenum::ports::CanFrame;

inline constexpr char kSlcanEnd = '\r';
inline constexpr char kSlcanRefused = '\a';

/// With its carriage return.
std::string slcan_line(const CanFrame& frame);
/// The frame of a line without its carriage return; empty for any other line.
std::optional<CanFrame> parse_slcan(std::string_view line);
/// The digit behind S for a bit rate; empty for one that adapters do not have.
std::optional<char> slcan_rate(std::uint32_t bit_rate);

}  // namespace plenum::host::wire
