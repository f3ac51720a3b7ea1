#include "firmware/config/model_set.hpp"

#include <algorithm>
#include <bit>

namespace plenum::config {
namespace {

static_assert(kChambers == 8, "a set names its chambers in a mask of eight bits");
constexpr std::size_t kImagesBegin = 1;

}  // namespace

/// Empty when the bytes from `at` on hold no whole image.
std::span<const std::uint8_t> ModelSet::image_at(std::size_t at) const noexcept {
  return first_image(std::span(bytes_).subspan(at, size_ - at));
}

bool ModelSet::take(std::span<const std::uint8_t> bytes) noexcept {
  left_ = 0;
  if (bytes.size() <= kImagesBegin || bytes.size() > bytes_.size() || bytes[0] == 0) return false;
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
  size_ = bytes.size();
  at_ = kImagesBegin;
  std::size_t end = kImagesBegin;
  for (unsigned chambers = bytes[0]; chambers != 0; chambers &= chambers - 1) {
    const std::size_t length = image_at(end).size();
    if (length == 0) return false;
    end += length;
  }
  if (end != size_) return false;
  left_ = bytes[0];
  return true;
}

ModelSet::One ModelSet::next() noexcept {
  const One one{static_cast<std::uint8_t>(std::countr_zero(left_)), image_at(at_)};
  at_ += one.image.size();
  left_ = static_cast<std::uint8_t>(left_ & (left_ - 1U));
  return one;
}

}  // namespace plenum::config
