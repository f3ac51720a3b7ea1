// Where settings are changed and read back: the seam between the bus and the controller.
//
// A change is judged at once by validate(), and takes effect at the next tick's edge, when the controller asks what has changed.
// Invariant: the settings in force have passed validate().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/config/chamber_settings.hpp"
#include "firmware/config/limits.hpp"
#include "firmware/config/seal.hpp"

namespace plenum::config {

/// The last change that was refused.
struct SettingRefusal {
  std::uint8_t chamber = 0;  ///< the chamber + 1; 0: a setting of the board
  SettingVerdict verdict;    ///< good when none was refused
};

class SettingsDesk {
 public:
  using Chambers = std::array<ChamberSettings, kChambers>;

  /// Defaults for everything.
  SettingsDesk() noexcept : SettingsDesk(BoardSettings{}, Chambers{}) {}
  /// The installer's settings, which have passed validate().
  SettingsDesk(const BoardSettings& board, const Chambers& chamber) noexcept
      : installed_board_(board), installed_chamber_(chamber), board_(board), chamber_(chamber) {
    for (std::size_t owner = 0; owner <= kChambers; ++owner) seal(owner);
  }

  const BoardSettings& board() const noexcept { return board_; }
  /// `chamber` < kChambers, here and below.
  const ChamberSettings& chamber(std::size_t chamber) const noexcept { return chamber_[chamber]; }

  /// No bit has flipped in the settings in force of a chamber, or with kChambers of the board, since they were written.
  bool intact(std::size_t owner) const noexcept { return seal_[owner] == sum_in_force(owner); }

  bool intact() const noexcept {
    for (std::size_t owner = 0; owner <= kChambers; ++owner) {
      if (!intact(owner)) return false;
    }
    return true;
  }
  /// What edited() gives may be set() again with one field changed: of damaged settings the rest would be sealed as if it were good.
  bool may_edit(std::size_t owner) const noexcept { return restoring_ || intact(owner); }

  /// Refused settings change nothing; why they were refused is kept as refusal().
  SettingVerdict set(const BoardSettings& settings) noexcept;
  SettingVerdict set(std::size_t chamber, const ChamberSettings& settings) noexcept;
  const SettingRefusal& refusal() const noexcept { return refusal_; }

  /// A stored set comes back over the installer's settings, and what the bus has written since is gone. It comes field by field, in
  /// an order that knows nothing of the relations between fields, and over many ticks: from here on nothing is judged, and what
  /// was in force stays so ...
  void begin_restore() noexcept;
  bool restoring() const noexcept { return restoring_; }
  /// What the next field goes into: the settings in force, or the half of a set that has come back so far.
  const BoardSettings& edited_board() const noexcept { return restoring_ ? restored_board_ : board_; }
  const ChamberSettings& edited(std::size_t chamber) const noexcept {
    return restoring_ ? restored_chamber_[chamber] : chamber_[chamber];
  }
  /// A stored value of this chamber, or with kChambers of the board, could not be read: its settings are not to be taken.
  void refuse_restored(std::size_t owner) noexcept;
  /// A value of it has come back; of who has none the installer's settings are taken, which need no judgement.
  bool has_restored(std::size_t owner) const noexcept { return (came_back_ >> owner & 1U) != 0; }
  /// ... until here, one owner after the other, a chamber or kChambers, the board. Who was refused keeps the installer's settings,
  /// and so does one whose restored settings are not admissible. Returns false for the latter.
  bool take_restored(std::size_t owner) noexcept;
  /// After the last of them.
  void end_restore() noexcept { restoring_ = false; }

  /// Chambers whose settings have changed since the last call (bit c: chamber c).
  std::uint8_t take_changed() noexcept;

 private:
  std::uint64_t sum_in_force(std::size_t owner) const noexcept {
    return owner == kChambers ? sum_of_object(board_) : sum_of_object(chamber_[owner]);
  }
  void seal(std::size_t owner) noexcept { seal_[owner] = sum_in_force(owner); }

  BoardSettings installed_board_;
  Chambers installed_chamber_{};
  BoardSettings board_;
  Chambers chamber_{};
  std::array<std::uint64_t, kChambers + 1> seal_{};  ///< of chambers and board, in force
  bool restoring_ = false;
  BoardSettings restored_board_;  ///< while restoring_, as the next
  Chambers restored_chamber_{};
  std::uint32_t came_back_ = 0;  ///< bit c: has_restored(c)
  std::uint32_t refused_ = 0;    ///< bit c: refuse_restored(c)
  std::uint8_t changed_ = 0;
  SettingRefusal refusal_;
};

}  // namespace plenum::config
