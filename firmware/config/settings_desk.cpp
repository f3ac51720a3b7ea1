#include "firmware/config/settings_desk.hpp"

namespace plenum::config {

SettingVerdict SettingsDesk::set(const BoardSettings& settings) noexcept {
  const SettingVerdict verdict = restoring_ ? SettingVerdict{} : validate(settings);
  if (verdict) {
    board_ = settings;
  } else {
    refusal_ = {0, verdict};
  }
  return verdict;
}

SettingVerdict SettingsDesk::set(std::size_t chamber, const ChamberSettings& settings) noexcept {
  const SettingVerdict verdict = restoring_ ? SettingVerdict{} : validate(settings);
  if (verdict) {
    chamber_[chamber] = settings;
    changed_ = static_cast<std::uint8_t>(changed_ | 1U << chamber);
  } else {
    refusal_ = {static_cast<std::uint8_t>(chamber + 1), verdict};
  }
  return verdict;
}

void SettingsDesk::begin_restore() noexcept {
  board_ = installed_board_;
  chamber_ = installed_chamber_;
  changed_ = 0xFF;
  restoring_ = true;
  refused_ = 0;
}

void SettingsDesk::refuse_restored(std::size_t chamber) noexcept {
  refused_ |= 1U << chamber;
}

bool SettingsDesk::end_restore() noexcept {
  restoring_ = false;
  const BoardSettings board = board_;
  board_ = installed_board_;
  const auto taken = [&](std::size_t c) { return (refused_ >> c & 1U) == 0; };
  bool all_kept = !taken(kChambers) || set(board);
  for (std::size_t c = 0; c < kChambers; ++c) {
    const ChamberSettings chamber = chamber_[c];
    chamber_[c] = installed_chamber_[c];
    if (taken(c)) all_kept = static_cast<bool>(set(c, chamber)) && all_kept;
  }
  return all_kept;
}

std::uint8_t SettingsDesk::take_changed() noexcept {
  const std::uint8_t changed = changed_;
  changed_ = 0;
  return changed;
}

}  // namespace plenum::config
