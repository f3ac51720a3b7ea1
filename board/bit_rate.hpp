// The bit rate of a board's CAN interface: which one it is to run at, and setting it before the board starts.
#pragma once

#include <filesystem>
#include <string>

#include "board/config/board_file.hpp"
#include "board/drivers/can_bit_rate.hpp"
#include "firmware/config/lss_settings.hpp"

namespace plenum::board {

/// A rate, and who says so.
struct BitRate {
  unsigned kbit = 0;
  std::string of;
};

/// What LSS has stored in the slots of this folder; nothing where it has none that is whole. Makes and changes none, and follows no link.
plenum::config::LssSettings stored_lss(const std::filesystem::path& folder);

/// The one that board.toml states; where it states none, the one that LSS stored, and 1000 kbit/s until then.
BitRate wanted_bit_rate(const config::BoardFile& board, const plenum::config::LssSettings& stored);

/// Empty: the interface runs at that one, or can have none. A board at another rate hears nothing but errors, and disturbs all others.
std::string bit_rate_trouble(const drivers::CanInterface& interface, const BitRate& wanted,
                             const std::string& name);

/// Has the interface up at the wanted rate; leaves it alone where it is, or where it can have none. Returns what was done, in a line; empty:
/// nothing. Throws std::runtime_error: what, where, expected.
std::string set_bit_rate(const config::BoardFile& board);

}  // namespace plenum::board
