// The values that 1010h keeps, as rows of the stored set, and their way back into the dictionary.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/canopen/object_dictionary.hpp"
#include "firmware/config/parameter_record.hpp"

namespace plenum::canopen {

/// The group of a stored row, by its index alone: a row of other firmware has one, too. `no` for a model image, and below
/// 1000h.
constexpr Kept group_of_row(std::uint16_t index) noexcept {
  const bool model = index >= object::kActiveModel && index < object::kActiveModel + config::kChambers;
  if (index < 0x1000 || model) return Kept::no;
  return index < 0x2000 ? Kept::communication : Kept::application;
}

/// Adds every value of `group` in the order of the table.
void collect_kept(const Device& device, Kept group, config::RowWriter& rows) noexcept;

/// Rows of 2400h to 2419h: whose settings they are; config::kChambers: the board's.
constexpr bool is_setting(std::uint16_t index) noexcept {
  return index >= object::kChamberSettings && index <= object::kBoardTicks;
}
constexpr std::size_t owner_of_setting(std::uint16_t index) noexcept {
  return index >= object::kBoardSettings ? config::kChambers
                                         : (index - object::kChamberSettings) % config::kChambers;
}

struct Restored {
  std::uint16_t skipped = 0;  ///< rows that this firmware does not know, does not keep, or does not admit
  std::uint32_t first_skipped = 0;  ///< index << 8 | sub-index; valid when any was skipped
  bool settings_lost = false;       ///< one of them was a setting: a limit may have been lost

  void skip(std::uint16_t index, std::uint8_t sub) noexcept {
    if (skipped == 0) first_skipped = std::uint32_t{index} << 8 | sub;
    if (skipped < 0xFFFF) ++skipped;
    settings_lost = settings_lost || is_setting(index);
  }
};

/// Writes the rows of `group` in `body` as a client would, a PDO in the order that CiA 301 asks for (7.5.2.35 ff.): switched
/// off, mapping emptied, objects, their count, the rest, its identifier. Rows of other groups are passed over.
///
/// `saved_id`: the node id when the rows were collected. Identifiers that ended in it follow a node id that has changed
/// since; otherwise two boards could share them, and none could be told why.
///
/// A chamber, or the board, one of whose settings is skipped keeps the installer's: half of a set of limits is none.
void restore_kept(Device& device, Kept group, std::span<const std::uint8_t> body, std::uint8_t saved_id,
                  Restored& restored) noexcept;

}  // namespace plenum::canopen
