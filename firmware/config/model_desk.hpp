// Where models are handed in and read back: the seam between whoever brings bytes (the CANopen node, the
// start-up loader) and whoever keeps the parameter sets (ParameterSlots).
#pragma once

#include <cstdint>
#include <span>

#include "firmware/config/model_image.hpp"

namespace plenum::config {

/// Key of a commit (2120h:3): "comt" in memory, so that no stray write commits a set.
inline constexpr std::uint32_t kCommitKey = 0x746D6F63U;

/// Answer to a commit request. Anything but `accepted` changes nothing.
enum class CommitResult : std::uint8_t {
  accepted,        ///< the named sets become active at the next tick's edge, all at once
  bad_key,         ///< the key is not kCommitKey
  empty_mask,      ///< no chamber is named
  nothing_staged,  ///< a chamber is named that has no accepted image staged
  bad_crc,         ///< the CRC-32 is not that of the named staged images, concatenated in chamber order
  pending          ///< an earlier commit still waits for the tick's edge
};

/// Where one chamber's set stands (2128h).
enum class SlotState : std::uint8_t {
  empty,   ///< no set is active, none is staged
  active,  ///< a set is active, none is staged
  staged,  ///< an accepted image waits for a commit (a set may be active besides)
  pending  ///< committed, waits for the tick's edge
};

struct SetState {
  SlotState state = SlotState::empty;
  ImageVerdict refused;  ///< why the last image was refused; `none` once an image has been accepted after it
  std::uint32_t crc_active = 0;  ///< CRC-32 that ends the active image; 0: none is active
  std::uint32_t generation =
      0;  ///< number of the commit that brought the active set, counted over the board; 0: none
};

class ModelDesk {
 public:
  /// Takes one whole image for `chamber`. A refused image changes neither the active nor the staged set.
  virtual ImageVerdict stage(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept = 0;
  /// The bytes of the active set; empty when there is none. Valid until the next tick's edge.
  virtual std::span<const std::uint8_t> active_image(std::uint8_t chamber) const noexcept = 0;
  /// Asks that the staged sets of the chambers in `mask` (bit c: chamber c) become active together.
  virtual CommitResult commit(std::uint8_t mask, std::uint32_t crc, std::uint32_t key) noexcept = 0;
  virtual SetState state(std::uint8_t chamber) const noexcept = 0;

 protected:
  ~ModelDesk() = default;
};

}  // namespace plenum::config
