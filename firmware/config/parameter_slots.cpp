#include "firmware/config/parameter_slots.hpp"

#include <algorithm>

namespace plenum::config {
namespace {

static_assert(kChambers == 8, "a commit names its chambers in a mask of eight bits");

bool names(std::uint8_t mask, std::size_t chamber) noexcept {
  return ((std::uint32_t{mask} >> chamber) & 1U) != 0;
}

}  // namespace

ImageVerdict ParameterSlots::stage(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept {
  if (chamber >= kChambers) return {.error = ImageError::no_such_chamber};
  Slot& slot = slots_[chamber];
  slot.refusal = check_and_stage(slot, names(pending_, chamber), image);
  return slot.refusal;
}

ImageVerdict ParameterSlots::check_and_stage(Slot& slot, bool pending,
                                             std::span<const std::uint8_t> image) noexcept {
  // The commit's CRC was taken over the staged image, so that image may not change before it is active.
  if (pending) return {.error = ImageError::commit_pending};
  Set& staged = slot.staged_set();
  const ImageVerdict verdict = decode(image, staged.parameters);
  staged.size = verdict ? image.size() : 0;
  // decode() accepts no size beyond kMaxImageBytes.
  std::copy_n(image.begin(), staged.size, staged.image.begin());
  return verdict;
}

std::span<const std::uint8_t> ParameterSlots::active_image(std::uint8_t chamber) const noexcept {
  if (chamber >= kChambers) return {};
  return slots_[chamber].active_set().bytes();
}

CommitResult ParameterSlots::commit(std::uint8_t mask, std::uint32_t crc, std::uint32_t key) noexcept {
  if (key != kCommitKey) return CommitResult::wrong_key;
  if (mask == 0) return CommitResult::nothing_staged;
  if (pending_ != 0) return CommitResult::not_now;
  std::array<std::uint32_t, kChambers> image_crcs{};
  std::size_t count = 0;
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    if (!names(mask, chamber)) continue;
    const Set& staged = slots_[chamber].staged_set();
    if (staged.size == 0) return CommitResult::nothing_staged;
    image_crcs[count++] = trailing_crc(staged.bytes());
  }
  if (commit_crc(std::span(image_crcs).first(count)) != crc) return CommitResult::wrong_crc;
  pending_ = mask;
  return CommitResult::accepted;
}

std::uint8_t ParameterSlots::apply_at_tick_edge() noexcept {
  const std::uint8_t changed = pending_;
  if (changed == 0) return 0;
  ++generation_;
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    if (!names(changed, chamber)) continue;
    Slot& slot = slots_[chamber];
    slot.active = 1 - slot.active;
    slot.staged_set().size = 0;
    slot.generation = generation_;
  }
  pending_ = 0;
  return changed;
}

const ModelParameters& ParameterSlots::active(std::size_t chamber) const noexcept {
  return slots_[chamber].active_set().parameters;
}

SetState ParameterSlots::state(std::uint8_t chamber) const noexcept {
  if (chamber >= kChambers) return {};
  const Slot& slot = slots_[chamber];
  SetState state;
  state.refusal = slot.refusal;
  state.generation = slot.generation;
  state.active_crc = trailing_crc(slot.active_set().bytes());
  if (names(pending_, chamber)) {
    state.phase = SetPhase::committed;
  } else if (slot.staged_set().size != 0) {
    state.phase = SetPhase::staged;
  } else if (!slot.refusal) {
    state.phase = SetPhase::refused;
  } else if (slot.active_set().size != 0) {
    state.phase = SetPhase::active;
  }
  return state;
}

}  // namespace plenum::config
