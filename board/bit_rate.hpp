// The bit rate of a board's CAN interface: which one it is to run at, setting it, and which ones LSS may give.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "board/config/board_file.hpp"
#include "board/drivers/can_bit_rate.hpp"
#include "firmware/config/lss_settings.hpp"

namespace plenum::board {

/// A rate, and who says so.
struct BitRate {
  std::uint32_t bit_s = 0;
  std::string of;
};

/// What LSS has stored in the slots of this folder; empty: they cannot be read, or something was stored there of which nothing is whole.
/// Makes and changes none, and follows no link.
std::optional<plenum::config::LssSettings> stored_lss(const std::filesystem::path& folder);

/// The one that board.toml states; where it states none, what LSS has stored; else that at which the interface runs by whoever has set it
/// up, and 1000 kbit/s where nobody has.
BitRate wanted_bit_rate(const config::BoardFile& board, const plenum::config::LssSettings& stored,
                        const drivers::CanInterface& interface);

/// Empty: the interface runs at that one, or can have none. A board at another rate hears nothing but errors, and disturbs all others.
std::string bit_rate_trouble(const drivers::CanInterface& interface, const BitRate& wanted,
                             const std::string& name);

/// Has the interface up at the wanted rate; leaves it alone where it is, or where it can have none. Returns what was done, or why nothing
/// was, in a line; empty: nothing was to be done. Throws std::runtime_error: what, where, expected.
std::string set_bit_rate(const config::BoardFile& board);

/// Which rates LSS may give, as canopen::Config::bit_rates: those that the file offers and the interface can run at; all that the file
/// offers where there is no interface yet, or it does not say.
std::uint16_t rates_for_lss(const config::BoardFile& board,
                            const std::optional<drivers::CanInterface>& interface);

}  // namespace plenum::board
