// The parameter sets of a board: for each chamber an active set and a staged one, swapped at a tick's edge.
//
//   stage(image): checked, decoded, staged, its inverse checked by a ModelProof, and compared with the active one by a ModelTrial
//   hand_in(image): the same at the next tick's edge
//   hand_in(set): the same with the images of several chambers, one at each tick's edge; all are staged or none
//     -> commit(mask, crc, key): pending -> apply_at_tick_edge(): active
//
// Invariants: an active set has passed every check of decode() and, where there is one, of the ModelProof, and was not doubted
// when it was committed, or was forced; the sets of one commit become active in the same tick or not at all; nothing that is refused touches an
// active set. Only whole images are taken: the caller collects the segments of an upload, so an upload that breaks
// off never reaches this class. All calls come from one thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/config/limits.hpp"
#include "firmware/config/model_desk.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/config/model_set.hpp"
#include "firmware/config/seal.hpp"
#include "firmware/config/twice.hpp"

namespace plenum::config {

/// Who checks that a staged model's inverse holds, before anything else is done with it (firmware/inverse_run.hpp).
class ModelProof {
 public:
  /// An image has been staged; ParameterSlots::prove() is told the result.
  virtual void begin(std::uint8_t chamber) noexcept = 0;

 protected:
  ~ModelProof() = default;
};

/// Who compares a staged model with the one in force before it may be committed (firmware/shadow_run.hpp).
class ModelTrial {
 public:
  /// An image has been staged for a chamber that has a model. Returns false when there is nothing to compare
  /// them by; otherwise ParameterSlots::judge() is told the result.
  virtual bool begin(std::uint8_t chamber) noexcept = 0;

 protected:
  ~ModelTrial() = default;
};

/// What is built into a chamber; 0: not stated.
struct Serials {
  std::uint32_t valve = 0;
  std::uint32_t sensor = 0;
};

class ParameterSlots final : public ModelDesk {
 public:
  /// Without a trial nothing is compared, without a proof no inverse is checked. Both must outlive the slots.
  explicit ParameterSlots(ModelTrial* trial = nullptr, ModelProof* proof = nullptr) noexcept
      : trial_(trial), proof_(proof) {
    for (Slot& slot : slots_) slot.seal.close(slot.active_memory());
  }

  /// Images that state other serial numbers will be doubted. `chamber` < kChambers.
  void expect(std::size_t chamber, const Serials& serials) noexcept { slots_[chamber].serials = serials; }

  /// At once, for who need not mind how long that takes. A refused image leaves an earlier staged one discarded, and never
  /// touches the one in force. `chamber` < kChambers.
  ImageVerdict stage(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept;
  ImageError hand_in(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept override;
  ImageJudgement judgement() const noexcept override { return {handed_in_.waits, handed_in_.verdict}; }
  SetHandIn hand_in(std::span<const std::uint8_t> set) noexcept override;
  SetProgress set_progress() const noexcept override { return {staging_set(), refused_of_set_}; }
  std::span<const std::uint8_t> active_image(std::uint8_t chamber) const noexcept override;
  CommitResult commit(std::uint8_t mask, std::uint32_t crc, std::uint32_t key) noexcept override;
  SetState state(std::uint8_t chamber) const noexcept override;
  ModelPoint failing_point(std::uint8_t chamber) const noexcept override;
  void forget_staged() noexcept override;
  UploadSession& upload_session() noexcept override { return session_; }
  const UploadSession& upload_session() const noexcept override { return session_; }

  /// A check that the proof has begun is still wanted. `chamber` < kChambers.
  bool proving(std::size_t chamber) const noexcept { return slots_[chamber].proving; }
  /// The proof's result; what is refused is no longer staged, nor is the set that it came with. Without effect when it is no longer
  /// wanted. `point`: where it failed, if anywhere.
  void prove(std::size_t chamber, const ImageVerdict& verdict, const ModelPoint& point) noexcept;
  /// A comparison that the trial has begun is still wanted. `chamber` < kChambers.
  bool checking(std::size_t chamber) const noexcept;
  /// The staged set, while proving() or checking().
  const ModelParameters& staged(std::size_t chamber) const noexcept {
    return slots_[chamber].staged_set().parameters;
  }
  /// The trial's result. Without effect when it is no longer wanted.
  void judge(std::size_t chamber, const TrialResult& result) noexcept;

  /// A tick begins: swaps in the sets of a pending commit, and stages the image, or one image of the set, that was handed in.
  /// Returns the chambers whose active set has changed (bit c: chamber c).
  std::uint8_t apply_at_tick_edge() noexcept;

  /// The active set; kind `none` when the chamber has none. Valid until the next tick's edge. `chamber` <
  /// kChambers.
  const ModelParameters& active(std::size_t chamber) const noexcept;

  /// No bit has flipped in the commit that waits, and none in the piece of the active set that is looked at with this call.
  /// `chamber` < kChambers.
  bool intact(std::size_t chamber) noexcept {
    Slot& slot = slots_[chamber];
    return slot.seal.look(slot.active_memory()) && pending_.intact();
  }

  /// Commits applied since start.
  std::uint32_t generation() const noexcept { return generation_; }

 private:
  struct Set {
    ModelParameters parameters;
    std::array<std::uint8_t, kMaxImageBytes> image{};
    std::size_t size = 0;  // 0: empty

    std::span<const std::uint8_t> bytes() const noexcept {
      return std::span(image).first(size <= image.size() ? size : 0);  // not beyond it, whatever has flipped
    }
  };
  struct Slot {
    std::array<Set, 2> set;
    std::size_t active = 0;  // its last bit: index into set; the other one is staged
    LongSeal seal;           // of the active set
    std::uint32_t generation = 0;
    ImageVerdict refusal;  // of the image handed in last
    ImageVerdict doubt;    // of the image staged
    TrialResult trial;     // of the image staged last
    ModelPoint point;      // where the image handed in last has failed
    bool proving = false;  // what is staged
    Serials serials;
    std::uint32_t expected_serial = 0;

    std::span<const std::byte> active_memory() const noexcept {
      return std::as_bytes(std::span(&active_set(), 1));
    }
    const Set& active_set() const noexcept { return set[active & 1U]; }
    const Set& staged_set() const noexcept { return set[~active & 1U]; }
    Set& staged_set() noexcept { return set[~active & 1U]; }
  };

  /// The image that was handed in last.
  struct HandedIn {
    bool waits = false;  // for the tick's edge
    std::uint8_t chamber = 0;
    std::size_t size = 0;
    std::array<std::uint8_t, kMaxImageBytes> bytes{};
    ImageVerdict verdict;  // when it does not wait
  };

  ImageError let_in(std::size_t chamber) noexcept;
  ImageVerdict stage_let_in(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept;
  void stage_handed_in() noexcept;
  static ImageVerdict stage_checked(Slot& slot, std::span<const std::uint8_t> image) noexcept;
  void stage_next_of_set() noexcept;
  bool staging_set() const noexcept;
  void refuse_set(std::size_t chamber) noexcept;
  static void discard_staged(Slot& slot) noexcept;
  void prove_or_try(Slot& slot, std::uint8_t chamber) noexcept;
  void doubt_or_try(Slot& slot, std::uint8_t chamber) noexcept;
  static SetPhase phase_of(const Slot& slot) noexcept;

  ModelTrial* trial_;
  ModelProof* proof_;
  UploadSession session_;
  std::array<Slot, kChambers> slots_;
  HandedIn handed_in_;
  ModelSet set_;
  std::uint8_t staged_of_set_ = 0;  // mask: staged so far of the set handed in last
  std::uint8_t refused_of_set_ = 0;
  Twice<std::uint8_t> pending_{0};  // mask of the accepted commit that waits for the tick's edge
  std::uint32_t generation_ = 0;
};

}  // namespace plenum::config
