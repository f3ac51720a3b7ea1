// The values that 1010h keeps, as rows of the stored set, and their way back into the dictionary.
#pragma once

#include <array>
#include <cstddef>
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

/// An identifier of a board that had the node id `saved_id` (0: none), when it has `now`: one that holds the id follows it.
std::uint32_t moved(std::uint32_t cob_id, std::uint8_t saved_id, std::uint8_t now) noexcept;

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

/// How much of a reset one tick may do. A unit is about the cost of looking at one stored row, some 15 instructions.
class Work {
 public:
  explicit Work(int units) noexcept : all_(units), left_(units) {}

  bool is_left() const noexcept { return left_ > 0; }
  /// A piece begins while any is left; one as dear as this waits for a tick that has room for it, or does nothing else.
  bool has_room_for(int units) const noexcept { return left_ >= units || left_ == all_; }
  void take(int units) noexcept { left_ -= units; }
  void end() noexcept { left_ = 0; }

 private:
  int all_;
  int left_;
};

/// Writes stored rows of one group as a client would, a PDO in the order that CiA 301 asks for (7.5.2.35 ff.): switched off and
/// emptied; its objects, and all that is no PDO's; the count of the objects; its identifier. Rows of other groups are passed over.
/// The rows are expected in the order of collect_kept(), which has a PDO's identifier before its mapping, and the count of a
/// mapping before its objects; what another order keeps from being written is skipped.
///
/// A chamber, or the board, one of whose settings is skipped keeps the installer's: half of a set of limits is none.
class KeptRestoration {
 public:
  /// `body` stays where it is until go_on() is done, or begin() comes again.
  ///
  /// `saved_id`: the node id when the rows were collected. Identifiers that ended in it follow a node id that has changed
  /// since; otherwise two boards could share them, and none could be told why.
  void begin(Kept group, std::span<const std::uint8_t> body, std::uint8_t saved_id) noexcept;

  /// As many rows as `work` allows. Returns true when all are done.
  bool go_on(Device& device, Restored& restored, Work& work) noexcept;

 private:
  static constexpr std::size_t kPdos = kRpdos + kTpdos;

  /// Rows that have to wait for others.
  template <std::size_t capacity>
  struct Waiting {
    std::array<config::RecordRow, capacity> row{};
    std::size_t count = 0;
    std::size_t done = 0;

    bool add(const config::RecordRow& later) noexcept {
      if (count == capacity) return false;
      row[count++] = later;
      return true;
    }
    const config::RecordRow* next() const noexcept { return done == count ? nullptr : &row[done]; }
  };

  Found look_up(const config::RecordRow& row) noexcept;
  void take(Device& device, Restored& restored, const config::RecordRow& row, Work& work) noexcept;
  void write(Device& device, Restored& restored, const config::RecordRow& row) noexcept;
  bool set_aside(Device& device, const config::RecordRow& row) noexcept;

  Kept group_ = Kept::no;
  config::RowReader rows_{{}};
  std::uint8_t saved_id_ = 0;
  const Entry* near_ = nullptr;  ///< the entry of the row before: this row's is seldom far
  Waiting<kPdos> mapping_counts_;
  Waiting<kPdos + 2> identifiers_;  ///< of the PDOs, 1005h and 1014h
};

}  // namespace plenum::canopen
