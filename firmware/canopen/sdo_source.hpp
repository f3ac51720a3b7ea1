// Where an upload takes its bytes from: a copy of a short value, or a stream that is read as it is sent.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/canopen/object_dictionary.hpp"

namespace plenum::canopen {

inline constexpr std::size_t kSegmentBytes = 7;  ///< data of one SDO segment

class SdoSource {
 public:
  /// Finds out how long the value is and, unless it is a stream, copies it to `room`, so that what changes
  /// between two segments cannot mix old and new. `found` has an entry. no_data when there is none.
  Abort open(Device& device, const Found& found, std::span<std::uint8_t> room) noexcept;

  /// Bytes in all; 0: not known before the end.
  std::uint32_t size() const noexcept { return size_; }
  /// Offset of what next() will yield.
  std::uint32_t position() const noexcept { return position_; }
  /// Nothing follows what next() has yielded.
  bool at_end() const noexcept { return ahead_count_ == 0; }
  /// The stream has ended before the size it told.
  bool is_short() const noexcept { return at_end() && size_ != 0 && position_ != size_; }

  /// Yields the next bytes, seven unless the value ends; returns their count.
  std::size_t next(Device& device, std::span<std::uint8_t, kSegmentBytes> segment) noexcept;

  /// Goes back to an offset that has been yielded before.
  void seek(std::uint32_t offset) noexcept {
    position_ = offset;
    ahead_count_ = 0;
  }

 private:
  void read_ahead(Device& device) noexcept;

  const Entry* entry_ = nullptr;
  Place place_{};
  std::span<const std::uint8_t> held_;  ///< the copy; unused with a stream
  std::uint32_t size_ = 0;
  std::uint32_t position_ = 0;
  std::array<std::uint8_t, kSegmentBytes + 1> ahead_{};  ///< one byte more than a segment: is it the last?
  std::size_t ahead_count_ = 0;
};

}  // namespace plenum::canopen
