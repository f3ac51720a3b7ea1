// How a tick came to begin, as whoever paces the ticks knows it: the loop of the board, the rig.
#pragma once

#include <cstdint>

namespace plenum {

/// A tick that begins after the next one was due has overrun; the ones between never begin.
enum class Overrun : std::uint8_t {
  none,
  counted,  ///< in 2200h:2
  fault     ///< counted, and toward fault FF01h
};

struct TickTiming {
  Overrun overrun = Overrun::none;
  /// Ticks that were due before this one and never began: their time has passed all the same.
  std::uint32_t missed = 0;
  std::uint32_t latency_us = 0;   ///< from when it was due to when it began
  std::uint32_t scan_age_us = 0;  ///< of the newest scan of the analog inputs, as it began
};

}  // namespace plenum
