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
  const ImageError error = let_in(chamber);
  return error == ImageError::none ? stage_let_in(chamber, image) : ImageVerdict{.error = error};
}

ImageError ParameterSlots::hand_in(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept {
  if (image.size() > kMaxImageBytes) return ImageError::wrong_size;
  const ImageError error = let_in(chamber);
  if (error != ImageError::none) return error;
  handed_in_.waits = true;
  handed_in_.chamber = chamber;
  handed_in_.size = image.size();
  std::copy(image.begin(), image.end(), handed_in_.bytes.begin());
  return error;
}

void ParameterSlots::stage_handed_in() noexcept {
  handed_in_.waits = false;
  handed_in_.verdict = stage_let_in(handed_in_.chamber, std::span(handed_in_.bytes).first(handed_in_.size));
}

/// Whether an image of this chamber may be staged, whatever is in it; why not is told as the chamber's refusal.
ImageError ParameterSlots::let_in(std::size_t chamber) noexcept {
  if (chamber >= kChambers) return ImageError::no_such_chamber;
  ImageError error = ImageError::none;
  if (!session_.admit() || staging_set() || handed_in_.waits) {
    error = ImageError::staged_by_another;
  } else if (names(pending_, chamber)) {
    // The commit's CRC was taken over the staged image, so that image may not change before it is active.
    error = ImageError::commit_pending;
  }
  if (error != ImageError::none) slots_[chamber].refusal = {.error = error};
  return error;
}

ImageVerdict ParameterSlots::stage_let_in(std::uint8_t chamber,
                                          std::span<const std::uint8_t> image) noexcept {
  Slot& slot = slots_[chamber];
  slot.refusal = stage_checked(slot, image);
  if (!slot.refusal) return slot.refusal;
  staged_of_set_ = 0;  // it was whole before this one was let in
  prove_or_try(slot, chamber);
  return slot.refusal;
}

ImageVerdict ParameterSlots::stage_checked(Slot& slot, std::span<const std::uint8_t> image) noexcept {
  Set& staged = slot.staged_set();
  const ImageVerdict verdict = decode(image, staged.parameters);
  discard_staged(slot);
  if (!verdict) return verdict;
  staged.size = image.size();  // decode() accepts none beyond kMaxImageBytes
  std::copy_n(image.begin(), staged.size, staged.image.begin());
  return verdict;
}

SetHandIn ParameterSlots::hand_in(std::span<const std::uint8_t> set) noexcept {
  if (!session_.admit() || staging_set() || handed_in_.waits) return SetHandIn::not_now;
  if (!set_.take(set)) return SetHandIn::malformed;
  staged_of_set_ = 0;
  refused_of_set_ = 0;
  return SetHandIn::taken;
}

void ParameterSlots::stage_next_of_set() noexcept {
  const ModelSet::One one = set_.next();
  Slot& slot = slots_[one.chamber];
  slot.refusal = stage_checked(slot, one.image);
  if (!slot.refusal) {
    refuse_set(one.chamber);
    return;
  }
  staged_of_set_ = static_cast<std::uint8_t>(staged_of_set_ | 1U << one.chamber);
  prove_or_try(slot, one.chamber);
}

/// Until the last of its images is staged and proved, so that its outcome is that of all.
bool ParameterSlots::staging_set() const noexcept {
  bool under_way = set_.left() != 0;
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    under_way = under_way || (names(staged_of_set_, chamber) && slots_[chamber].proving);
  }
  return under_way;
}

/// Because of this chamber's image: none of it is staged.
void ParameterSlots::refuse_set(std::size_t chamber) noexcept {
  set_.clear();
  refused_of_set_ = static_cast<std::uint8_t>(chamber + 1);
  for (std::size_t one = 0; one < kChambers; ++one) {
    if (names(staged_of_set_, one)) discard_staged(slots_[one]);
  }
  staged_of_set_ = 0;
}

void ParameterSlots::forget_staged() noexcept {
  session_.end();
  handed_in_.waits = false;
  set_.clear();
  staged_of_set_ = 0;
  refused_of_set_ = 0;
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    if (names(pending_, chamber)) continue;
    discard_staged(slots_[chamber]);
    slots_[chamber].refusal = {};
  }
}

void ParameterSlots::discard_staged(Slot& slot) noexcept {
  slot.staged_set().size = 0;
  slot.proving = false;
  slot.doubt = {};
  slot.trial = {};
  slot.expected_serial = 0;
}

void ParameterSlots::prove_or_try(Slot& slot, std::uint8_t chamber) noexcept {
  slot.proving = proof_ != nullptr;
  if (slot.proving) {
    proof_->begin(chamber);
  } else {
    doubt_or_try(slot, chamber);
  }
}

void ParameterSlots::prove(std::size_t chamber, const ImageVerdict& verdict,
                           const ModelPoint& point) noexcept {
  if (!proving(chamber)) return;
  Slot& slot = slots_[chamber];
  slot.proving = false;
  if (verdict) {
    doubt_or_try(slot, static_cast<std::uint8_t>(chamber));
    return;
  }
  slot.refusal = verdict;
  slot.point = point;
  if (names(staged_of_set_, chamber)) {
    refuse_set(chamber);
  } else {
    discard_staged(slot);
  }
}

void ParameterSlots::doubt_or_try(Slot& slot, std::uint8_t chamber) noexcept {
  const ModelParameters& staged = slot.staged_set().parameters;
  const auto differ = [](std::uint32_t stated, std::uint32_t expected) {
    return stated != 0 && expected != 0 && stated != expected;
  };
  slot.trial.outcome = Trial::not_compared;
  if (differ(staged.valve_serial, slot.serials.valve)) {
    slot.doubt = {.error = ImageError::wrong_serial, .parameter = kValveSerialField};
    slot.expected_serial = slot.serials.valve;
  } else if (differ(staged.sensor_serial, slot.serials.sensor)) {
    slot.doubt = {.error = ImageError::wrong_serial, .parameter = kSensorSerialField};
    slot.expected_serial = slot.serials.sensor;
  } else if (trial_ != nullptr && slot.active_set().size != 0 && trial_->begin(chamber)) {
    slot.trial.outcome = Trial::running;
  }
}

bool ParameterSlots::checking(std::size_t chamber) const noexcept {
  const Slot& slot = slots_[chamber];
  return !names(pending_, chamber) && !slot.proving && phase_of(slot) == SetPhase::checking;
}

void ParameterSlots::judge(std::size_t chamber, const TrialResult& result) noexcept {
  if (!checking(chamber)) return;
  Slot& slot = slots_[chamber];
  slot.trial = result;
  if (result.outcome == Trial::worse) slot.doubt = {.error = ImageError::predicts_worse};
}

std::span<const std::uint8_t> ParameterSlots::active_image(std::uint8_t chamber) const noexcept {
  if (chamber >= kChambers) return {};
  return slots_[chamber].active_set().bytes();
}

CommitResult ParameterSlots::commit(std::uint8_t mask, std::uint32_t crc, std::uint32_t key) noexcept {
  if (key != kCommitKey && key != kForceKey) return CommitResult::wrong_key;
  if (mask == 0) return CommitResult::nothing_staged;
  if (pending_ != 0 || staging_set() || handed_in_.waits) return CommitResult::not_now;
  std::array<std::uint32_t, kChambers> image_crcs{};
  std::size_t count = 0;
  bool proving = false;
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    if (!names(mask, chamber)) continue;
    const Set& staged = slots_[chamber].staged_set();
    if (staged.size == 0) return CommitResult::nothing_staged;
    proving = proving || slots_[chamber].proving;
    image_crcs[count++] = trailing_crc(staged.bytes());
  }
  if (commit_crc(std::span(image_crcs).first(count)) != crc) return CommitResult::wrong_crc;
  if (proving) return CommitResult::checking;
  if (key != kForceKey) {
    bool checking = false, doubted = false;
    for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
      if (!names(mask, chamber)) continue;
      checking = checking || phase_of(slots_[chamber]) == SetPhase::checking;
      doubted = doubted || phase_of(slots_[chamber]) == SetPhase::doubted;
    }
    if (doubted) return CommitResult::doubted;
    if (checking) return CommitResult::checking;
  }
  pending_ = mask;
  return CommitResult::accepted;
}

std::uint8_t ParameterSlots::apply_at_tick_edge() noexcept {
  session_.tick();
  if (!pending_.intact()) pending_ = 0;  // a commit that nobody has made
  const std::uint8_t changed = pending_;
  if (changed != 0) ++generation_;
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    if (!names(changed, chamber)) continue;
    Slot& slot = slots_[chamber];
    slot.active = ~slot.active & 1U;
    slot.seal.close(slot.active_memory());
    slot.staged_set().size = 0;
    slot.generation = generation_;
  }
  pending_ = 0;
  // after the swap: nothing waits for a commit any more
  if (set_.left() != 0) stage_next_of_set();
  if (handed_in_.waits) stage_handed_in();
  return changed;
}

const ModelParameters& ParameterSlots::active(std::size_t chamber) const noexcept {
  return slots_[chamber].active_set().parameters;
}

/// Of a slot that no commit waits for. An image that was not let in for reasons outside of it tells nothing of
/// the set.
SetPhase ParameterSlots::phase_of(const Slot& slot) noexcept {
  if (slot.staged_set().size != 0) {
    if (slot.proving) return SetPhase::checking;
    if (!slot.doubt) return SetPhase::doubted;
    return slot.trial.outcome == Trial::running ? SetPhase::checking : SetPhase::staged;
  }
  const ImageError refusal = slot.refusal.error;
  const bool let_in = refusal != ImageError::commit_pending && refusal != ImageError::staged_by_another;
  if (!slot.refusal && let_in) return SetPhase::refused;
  return slot.active_set().size != 0 ? SetPhase::active : SetPhase::empty;
}

SetState ParameterSlots::state(std::uint8_t chamber) const noexcept {
  if (chamber >= kChambers) return {};
  const Slot& slot = slots_[chamber];
  SetState state;
  state.phase = names(pending_, chamber) ? SetPhase::committed : phase_of(slot);
  state.refusal = state.phase == SetPhase::doubted ? slot.doubt : slot.refusal;
  state.active_crc = trailing_crc(slot.active_set().bytes());
  state.generation = slot.generation;
  state.trial = slot.trial;
  state.staged_crc = trailing_crc(slot.staged_set().bytes());
  state.expected_serial = slot.expected_serial;
  return state;
}

ModelPoint ParameterSlots::failing_point(std::uint8_t chamber) const noexcept {
  return chamber < kChambers ? slots_[chamber].point : ModelPoint{};
}

}  // namespace plenum::config
