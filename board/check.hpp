// plenumd --check and --safe: the devices one by one, without the loop.
#pragma once

#include "board/config/board_file.hpp"

namespace plenum::board {

/// Opens each device, reads what can be read, and prints a line a thing: "ok" or "FAIL", what, and what was found. Changes no
/// output: analog ones are opened and not written, digital ones looked at and not taken. Returns whether all is well.
bool check(const config::BoardFile& board);

/// Outputs at their safe values, as the last loop has left them or else as the file says, valve power off, vent open. Each is tried whatever the others say; prints what failed.
/// Returns whether all has been done.
bool make_safe(const config::BoardFile& board);

}  // namespace plenum::board
