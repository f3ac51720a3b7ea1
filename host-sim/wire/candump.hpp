// The log format of can-utils (candump -l, canplayer, log2asc): one frame a line,
//
//   (1700000000.123456) can0 181#0102        seconds, channel, identifier in three or eight digits, bytes
//   (1700000000.123456) can0 701#R1          a remote frame and its length
//   (1700000000.123456) can0 181##10102      a CAN FD frame: flags, bytes
//   (1700000000.123456) can0 20000004#0000000000000000   an error of the bus: an identifier above 29 bits
//
// Source: the lib of github.com/linux-can/can-utils, sprint_canframe().
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/ports/can_bus.hpp"

namespace plenum::host::wire {

using plenum::ports::CanFrame;

struct LoggedFrame {
  std::uint64_t time_us = 0;  ///< since the epoch, or since any other moment
  std::string channel;
  CanFrame frame;
  bool classic = true;  ///< false: an error of the bus, or a CAN FD frame, of which `frame` tells nothing
  /// An error of the bus that says: a receive buffer was full, and frames are missing here (CAN_ERR_CRTL of linux/can/error.h).
  bool frames_missing = false;
};

/// Such an error, as a frame of a log.
inline constexpr CanFrame kReceiveOverflow{.id = 0x2000'0004, .length = 8, .extended = true, .data = {0, 1}};

/// Without the line's end. Seconds have ten digits at least, as candump writes them.
std::string candump_line(std::uint64_t time_us, const std::string& channel, const CanFrame& frame);

/// Empty for what is no line of a frame.
std::optional<LoggedFrame> parse_candump(std::string_view line);

}  // namespace plenum::host::wire
