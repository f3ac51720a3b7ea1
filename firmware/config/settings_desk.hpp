// Where settings are changed and read back: the seam between the bus and the controller.
//
// A change is judged at once by validate(), and takes effect at the next tick's edge, when the controller asks what has changed.
// Invariant: the settings on the desk have passed validate(), but for what stands between begin_restore() and end_restore().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/config/chamber_settings.hpp"
#include "firmware/config/limits.hpp"

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
  SettingsDesk() noexcept = default;
  /// The installer's settings, which have passed validate().
  SettingsDesk(const BoardSettings& board, const Chambers& chamber) noexcept
      : installed_board_(board), installed_chamber_(chamber), board_(board), chamber_(chamber) {}

  const BoardSettings& board() const noexcept { return board_; }
  /// `chamber` < kChambers, here and below.
  const ChamberSettings& chamber(std::size_t chamber) const noexcept { return chamber_[chamber]; }

  /// Refused settings change nothing; why they were refused is kept as refusal().
  SettingVerdict set(const BoardSettings& settings) noexcept;
  SettingVerdict set(std::size_t chamber, const ChamberSettings& settings) noexcept;
  const SettingRefusal& refusal() const noexcept { return refusal_; }

  /// A stored set comes back over the installer's settings: these are put back, and what the bus has written since is gone. It
  /// comes field by field, in an order that knows nothing of the relations between fields: from here on nothing is judged ...
  void begin_restore() noexcept;
  bool restoring() const noexcept { return restoring_; }
  /// A stored value of this chamber, or with kChambers of the board, could not be read: its settings are not to be taken.
  void refuse_restored(std::size_t chamber) noexcept;
  /// ... until here. Chambers, or the board, whose settings are refused or not admissible keep the installer's. Returns
  /// false when any were not admissible.
  bool end_restore() noexcept;

  /// Chambers whose settings have changed since the last call (bit c: chamber c).
  std::uint8_t take_changed() noexcept;

 private:
  BoardSettings installed_board_;
  Chambers installed_chamber_{};
  BoardSettings board_;
  Chambers chamber_{};
  bool restoring_ = false;
  std::uint32_t refused_ = 0;  ///< bit c: refuse_restored(c)
  std::uint8_t changed_ = 0;
  SettingRefusal refusal_;
};

}  // namespace plenum::config
