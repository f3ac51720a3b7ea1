#include "firmware/canopen/sdo_source.hpp"

namespace plenum::canopen {

Abort SdoSource::open(Device& device, const Found& found, std::span<std::uint8_t> room) noexcept {
  entry_ = found.entry;
  place_ = found.place;
  position_ = 0;
  ahead_count_ = 0;
  held_ = {};
  size_ = 0;
  if (entry_->read_stream != nullptr) {
    std::uint32_t unused = 0;
    const Abort abort =
        entry_->read_value != nullptr ? entry_->read_value(device, place_, unused) : Abort::none;
    if (abort != Abort::none) return abort;
    if (entry_->stream_size != nullptr) size_ = entry_->stream_size(device, place_);
    read_ahead(device);
    return ahead_count_ == 0 ? Abort::no_data : Abort::none;
  }
  if (entry_->read_bytes != nullptr) {
    const std::span<const std::uint8_t> bytes = entry_->read_bytes(device, place_);
    if (bytes.empty() || bytes.size() > room.size()) return Abort::no_data;
    std::copy(bytes.begin(), bytes.end(), room.begin());
    held_ = room.first(bytes.size());
  } else {
    std::uint32_t bits = 0;
    const Abort abort = entry_->read_value(device, place_, bits);
    if (abort != Abort::none) return abort;
    held_ = room.first(size_of(entry_->type));
    store_le(bits, room.first(held_.size()));
  }
  size_ = static_cast<std::uint32_t>(held_.size());
  return Abort::none;
}

std::size_t SdoSource::next(Device& device, std::span<std::uint8_t, kSegmentBytes> segment) noexcept {
  read_ahead(device);
  const std::size_t count = std::min(ahead_count_, kSegmentBytes);
  std::copy_n(ahead_.begin(), count, segment.begin());
  position_ += static_cast<std::uint32_t>(count);
  ahead_count_ -= count;
  ahead_[0] = ahead_[kSegmentBytes];
  return count;
}

void SdoSource::read_ahead(Device& device) noexcept {
  const std::uint32_t from = position_ + static_cast<std::uint32_t>(ahead_count_);
  std::size_t wanted = ahead_.size() - ahead_count_;
  if (size_ != 0) wanted = std::min<std::size_t>(wanted, size_ - from);
  if (wanted == 0) return;
  const std::span<std::uint8_t> room = std::span(ahead_).subspan(ahead_count_, wanted);
  if (entry_->read_stream != nullptr) {
    ahead_count_ += entry_->read_stream(device, place_, from, room);
  } else {
    std::copy_n(held_.begin() + static_cast<std::ptrdiff_t>(from), wanted, room.begin());
    ahead_count_ += wanted;
  }
}

}  // namespace plenum::canopen
