#include "firmware/config/settings_desk.hpp"

namespace plenum::config {

SettingVerdict SettingsDesk::set(const BoardSettings& settings) noexcept {
  if (restoring_) {
    restored_board_ = settings;
    came_back_ |= 1U << kChambers;
    return {};
  }
  const SettingVerdict verdict = validate(settings);
  if (verdict) {
    board_ = settings;
    seal(kChambers);
  } else {
    refusal_ = {0, verdict};
  }
  return verdict;
}

SettingVerdict SettingsDesk::set(std::size_t chamber, const ChamberSettings& settings) noexcept {
  if (restoring_) {
    restored_chamber_[chamber] = settings;
    came_back_ |= 1U << chamber;
    return {};
  }
  const SettingVerdict verdict = validate(settings);
  if (verdict) {
    chamber_[chamber] = settings;
    seal(chamber);
    changed_ = static_cast<std::uint8_t>(changed_ | 1U << chamber);
  } else {
    refusal_ = {static_cast<std::uint8_t>(chamber + 1), verdict};
  }
  return verdict;
}

void SettingsDesk::begin_restore() noexcept {
  restored_board_ = installed_board_;
  restored_chamber_ = installed_chamber_;
  restoring_ = true;
  came_back_ = 0;
  refused_ = 0;
}

void SettingsDesk::refuse_restored(std::size_t owner) noexcept {
  refused_ |= 1U << owner;
}

bool SettingsDesk::take_restored(std::size_t owner) noexcept {
  const bool of_board = owner == kChambers;
  if (!of_board) changed_ = static_cast<std::uint8_t>(changed_ | 1U << owner);
  const bool came = (refused_ >> owner & 1U) == 0 && has_restored(owner);
  const auto settle = [came](auto& in_force, const auto& restored, const auto& installed) noexcept {
    const SettingVerdict verdict = came ? validate(restored) : SettingVerdict{};
    in_force = came && verdict ? restored : installed;
    return verdict;
  };
  const SettingVerdict verdict =
      of_board ? settle(board_, restored_board_, installed_board_)
               : settle(chamber_[owner], restored_chamber_[owner], installed_chamber_[owner]);
  seal(owner);
  if (!verdict) refusal_ = {static_cast<std::uint8_t>(of_board ? 0 : owner + 1), verdict};
  return static_cast<bool>(verdict);
}

std::uint8_t SettingsDesk::take_changed() noexcept {
  const std::uint8_t changed = changed_;
  changed_ = 0;
  return changed;
}

}  // namespace plenum::config
