// What a board remembers: the last ticks in which its valves were driven, read from its capture buffer (2300h, 2301h) by
// SDO blocks. The flight recorder after a fault, and a recording for a bus too slow to stream.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/session.hpp"

namespace plenum::host::client {

struct BoardLogRow {
  double pressure_Pa = 0.0;  ///< absolute, mean over the tick before the row's time
  double volume_m3 = 0.0;    ///< at the row's time
  double command_V = 0.0;    ///< held from the row's time on
  bool measured = false;     ///< the pressure is of that tick
  bool follows = false;      ///< the row before it is of the tick before
};

/// The log of one chamber.
struct BoardLog {
  std::uint32_t last_tick = 0;  ///< tick count of the board (2200h:1) at the last row
  double period_s = 0.0;
  std::vector<BoardLogRow> rows;  ///< the oldest first
};

/// The bytes of 2301h (layout: firmware/telemetry/recorder.hpp). Throws ProtocolError: what does not fit, and what was
/// expected.
BoardLog parse_board_log(std::span<const std::uint8_t> bytes, unsigned chamber);

struct Remembered {
  std::vector<CapturedRow>
      rows;                ///< the last stretch without a gap, all chambers; times from its first row on
  std::size_t before = 0;  ///< rows that the board holds from before the last gap
};

/// Whether the log stands as it was when somebody froze it, by whom it was not let go on.
bool log_is_frozen(Session& session);
/// Lets a frozen log go on. What it holds stays, from before a gap, until newer rows have taken its place.
void let_log_roll(Session& session);

/// Freezes the board's log, reads the chambers 0 to `chambers` - 1, and lets the log go on if it did. Throws as Session
/// does; Refused when the board is recording a log that another client has ordered, or remembers nothing.
Remembered remembered(Session& session, unsigned chambers, const Progress& progress = {});

}  // namespace plenum::host::client
