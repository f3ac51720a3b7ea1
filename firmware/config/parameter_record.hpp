// The bytes of a slot: a header that vouches for a body, and the rows of that body.
//
// Little endian, no padding:
//   0  u32  magic "PLS1"             row of the body:
//   4  u32  version, 1               0  u16  object index
//   8  u32  generation               2  u8   sub-index
//  12  u32  length of the body       3  u8   length n
//  16  u32  CRC-32 of the body       4  u8   value[n]
//  20  u32  CRC-32 of bytes 0..19
//  24  the body: rows, one after the other
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::config {

inline constexpr std::size_t kRecordHeaderBytes = 24;
inline constexpr std::size_t kRowHeaderBytes = 4;
inline constexpr std::size_t kMaxBodyBytes = std::size_t{16} * 1024;
inline constexpr std::size_t kMaxSlotBytes = kRecordHeaderBytes + kMaxBodyBytes;
inline constexpr std::uint32_t kRecordVersion = 1;

struct RecordHeader {
  std::uint32_t generation = 0;
  std::uint32_t length = 0;  ///< of the body
  std::uint32_t body_crc = 0;
};

using HeaderBytes = std::array<std::uint8_t, kRecordHeaderBytes>;

enum class HeaderState : std::uint8_t {
  blank,   ///< nothing was ever written here: all bytes 00h, or all FFh
  good,    ///< the body may be read, and judged by its CRC
  damaged  ///< or of a version that this firmware does not know
};

HeaderBytes encode_header(const RecordHeader& header) noexcept;
/// Writes `header` when the result is good.
HeaderState decode_header(const HeaderBytes& bytes, RecordHeader& header) noexcept;

/// Serial-number comparison (as RFC 1982): holds across the wrap-around of the counter.
constexpr bool is_newer(std::uint32_t generation, std::uint32_t than) noexcept {
  const std::uint32_t ahead = generation - than;
  return ahead != 0 && ahead < 0x8000'0000U;
}

/// One stored value: an object and its bytes, at most 255.
struct RecordRow {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::span<const std::uint8_t> value;
};

class RowWriter {
 public:
  explicit RowWriter(std::span<std::uint8_t> body) noexcept : body_(body) {}
  /// Returns false, writing nothing, when the row does not fit.
  bool add(const RecordRow& row) noexcept;
  std::size_t size() const noexcept { return size_; }
  /// A row did not fit.
  bool overflowed() const noexcept { return overflowed_; }

 private:
  std::span<std::uint8_t> body_;
  std::size_t size_ = 0;
  bool overflowed_ = false;
};

class RowReader {
 public:
  explicit RowReader(std::span<const std::uint8_t> body) noexcept : rest_(body) {}
  /// The next row; its value lies in the body. Returns false at the end, and at a row that the body cuts off.
  bool next(RecordRow& row) noexcept {
    if (rest_.size() < kRowHeaderBytes || rest_.size() - kRowHeaderBytes < rest_[3]) return false;
    row.index = static_cast<std::uint16_t>(rest_[0] | rest_[1] << 8);
    row.sub = rest_[2];
    row.value = rest_.subspan(kRowHeaderBytes, rest_[3]);
    rest_ = rest_.subspan(kRowHeaderBytes + row.value.size());
    return true;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

}  // namespace plenum::config
