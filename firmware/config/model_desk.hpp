// Where model images are handed in, checked and taken over: the seam between the bus and the parameter sets.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/config/crc32.hpp"
#include "firmware/config/limits.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/config/upload_session.hpp"

namespace plenum::config {

/// The key that makes a commit deliberate ("comt", little endian).
inline constexpr std::uint32_t kCommitKey = 0x746D6F63U;
/// The key that commits what the board doubts, or has not finished to compare ("forc", little endian).
inline constexpr std::uint32_t kForceKey = 0x63726F66U;

enum class SetPhase : std::uint8_t {
  empty = 0,      ///< no model: the chamber cannot be regulated in closed loop
  active = 1,     ///< a model is in force and nothing else is waiting
  staged = 2,     ///< a checked image waits for its commit (an older one may still be in force)
  committed = 3,  ///< the staged image is taken over at the next tick's edge
  refused = 4,    ///< the last image handed in was refused; what was in force before still is
  checking =
      5,  ///< a staged image's inverse is being checked, or it is being compared with the one in force; a commit has to
  ///< wait
  doubted = 6,  ///< staged, but the board objects (SetState::refusal): only kForceKey commits it
};

/// How a staged image has been compared with the one in force, over the log that the board has of the chamber.
enum class Trial : std::uint8_t {
  none = 0,  ///< nothing staged, or its inverse is still being checked
  running = 1,
  not_compared = 2,  ///< no model in force, or no log that would tell two models apart
  passed = 3,
  worse = 4,
};

struct TrialResult {
  Trial outcome = Trial::none;
  float staged_rms_kPa = 0.0F;  ///< of the free-running prediction; valid when passed or worse
  float active_rms_kPa = 0.0F;
};

/// Where a model has failed on the grid of its chamber (control/inverse_check.hpp): from `pressure_kPa`, in a tick.
struct ModelPoint {
  float pressure_kPa = 0.0F;
  float volume_mL = 0.0F;
  float command_V = 0.0F;
  float wanted_kPa = 0.0F;  ///< the pressure asked for, or due
  float came_kPa = 0.0F;    ///< and the one that came
};

/// State of one chamber's parameter set, as object 2128h+c shows it.
struct SetState {
  SetPhase phase = SetPhase::empty;
  ImageVerdict refusal;               ///< why the last image was refused or is doubted; good when it is not
  std::uint32_t active_crc = 0;       ///< last four bytes of the image in force; 0: none
  std::uint32_t generation = 0;       ///< the board's count of take-overs at the one of this image
  TrialResult trial;                  ///< of the image staged last
  std::uint32_t staged_crc = 0;       ///< last four bytes of the image staged; 0: none
  std::uint32_t expected_serial = 0;  ///< of `wrong_serial`: the one that the settings name
};

enum class CommitResult : std::uint8_t {
  accepted,
  wrong_key,
  wrong_crc,
  nothing_staged,  ///< the mask is empty or names a chamber without a staged image
  not_now,         ///< the state of the device forbids it
  checking,        ///< a staged image is still being checked or compared
  doubted          ///< the board objects to a staged image, and the key was not kForceKey
};

/// What becomes of a set that is handed in.
enum class SetHandIn : std::uint8_t {
  taken,      ///< its images are staged one after the other; SetProgress tells the outcome
  malformed,  ///< no set of whole images (model_set.hpp)
  not_now     ///< another set is being staged, or another master's upload session stands
};

/// How far the set handed in last is.
struct SetProgress {
  bool staging = false;
  std::uint8_t refused = 0;  ///< the chamber + 1 whose image was refused, so that none is staged; 0: none was
};

/// What has become of the image handed in last.
struct ImageJudgement {
  bool pending = false;  ///< it is judged at the next tick's edge
  ImageVerdict verdict;  ///< valid when not pending; good: the image is staged
};

/// Staging is per chamber or of a set, commit is for all chambers of a mask at once; nothing changes between ticks.
class ModelDesk {
 public:
  /// Keeps a copy of an image, which is judged at the next tick's edge: then it is staged, or refused, which leaves an earlier staged
  /// one discarded; judgement() tells. Until then nothing else is handed in and nothing committed. Returns none, or why it
  /// is not even judged. `chamber` < kChambers.
  virtual ImageError hand_in(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept = 0;
  virtual ImageJudgement judgement() const noexcept = 0;
  /// Stages the images of several chambers (model_set.hpp): all of them or, when one is refused, none. Keeps a copy, and
  /// stages one image at each tick's edge; until the last has been checked nothing else is staged and nothing is committed.
  virtual SetHandIn hand_in(std::span<const std::uint8_t> set) noexcept = 0;
  virtual SetProgress set_progress() const noexcept = 0;
  /// The image in force; empty when there is none. Valid until the next tick's edge.
  virtual std::span<const std::uint8_t> active_image(std::uint8_t chamber) const noexcept = 0;
  /// Takes over the staged images of the chambers in `mask` (bit c: chamber c), all of them at the next
  /// tick's edge or none. `crc` is commit_crc() of their trailing CRCs. `key`: kCommitKey, or kForceKey for
  /// images that the board doubts.
  virtual CommitResult commit(std::uint8_t mask, std::uint32_t crc, std::uint32_t key) noexcept = 0;
  virtual SetState state(std::uint8_t chamber) const noexcept = 0;
  /// Of `inverse_fails` and `no_authority`: where the image handed in last has failed.
  virtual ModelPoint failing_point(std::uint8_t chamber) const noexcept = 0;
  /// Every image that is staged or handed in and that no commit has been accepted for, and the upload session.
  virtual void forget_staged() noexcept = 0;
  /// Who may stage: upload_session.hpp.
  virtual UploadSession& upload_session() noexcept = 0;
  virtual const UploadSession& upload_session() const noexcept = 0;

 protected:
  ~ModelDesk() = default;
};

/// The CRC that an image carries in its last four bytes, little endian; 0 for fewer than four bytes.
inline std::uint32_t trailing_crc(std::span<const std::uint8_t> image) noexcept {
  std::uint32_t crc = 0;
  if (image.size() < 4) return crc;
  for (std::size_t i = 0; i < 4; ++i) crc |= std::uint32_t{image[image.size() - 4 + i]} << (8 * i);
  return crc;
}

/// What a commit is checked by: the CRC-32 of the images' own trailing CRCs (4 bytes each, little endian) in
/// chamber order. Not the CRC of the images one after the other: a message followed by its own CRC leaves the
/// same remainder whatever the message was, so such a CRC would tell nothing but the lengths. At most
/// kChambers entries count.
inline std::uint32_t commit_crc(std::span<const std::uint32_t> image_crcs) noexcept {
  std::array<std::uint8_t, 4 * kChambers> bytes{};
  std::size_t size = 0;
  for (const std::uint32_t crc : image_crcs) {
    if (size == bytes.size()) break;
    for (unsigned shift = 0; shift < 32; shift += 8) bytes[size++] = static_cast<std::uint8_t>(crc >> shift);
  }
  return crc32(std::span<const std::uint8_t>(bytes.data(), size));
}

}  // namespace plenum::config
