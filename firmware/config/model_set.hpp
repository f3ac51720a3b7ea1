// The model images of several chambers as one value, so that one transfer carries them all.
//
//   0  u8  mask, bit c: chamber c; not 0
//   1      the images of these chambers in chamber order, without gaps (model_image.hpp); each tells its own length by its
//          parameter count
//
// A ModelSet keeps a copy and is worked off image by image, so that nobody has to judge eight of them at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/config/limits.hpp"
#include "firmware/config/model_image.hpp"

namespace plenum::config {

inline constexpr std::size_t kMaxSetBytes = 1 + kChambers * kMaxImageBytes;

class ModelSet {
 public:
  /// Takes a copy of the bytes. Returns false, and is empty, when the mask is 0, or when the images that it names do not end
  /// where the bytes end. What is in the images is not judged.
  bool take(std::span<const std::uint8_t> bytes) noexcept;
  void clear() noexcept { left_ = 0; }

  /// Chambers whose image is still to be worked off (bit c: chamber c).
  std::uint8_t left() const noexcept { return left_; }

  struct One {
    std::uint8_t chamber = 0;
    std::span<const std::uint8_t> image;
  };
  /// The image of the lowest chamber left, which it takes off the set; valid until the next take(). Only while left() is not 0.
  One next() noexcept;

 private:
  std::span<const std::uint8_t> image_at(std::size_t at) const noexcept;

  std::array<std::uint8_t, kMaxSetBytes> bytes_{};
  std::size_t size_ = 0;
  std::size_t at_ = 0;  ///< where the next image begins
  std::uint8_t left_ = 0;
};

}  // namespace plenum::config
