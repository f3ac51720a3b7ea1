#include "firmware/config/parameter_record.hpp"

#include <algorithm>

#include "firmware/config/crc32.hpp"

namespace plenum::config {
namespace {

constexpr std::uint32_t kRecordMagic = 0x31534C50U;  // "PLS1"
constexpr std::size_t kVouchedBytes = kRecordHeaderBytes - 4;

void put(HeaderBytes& bytes, std::size_t at, std::uint32_t x) noexcept {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(x >> (8 * i));
}

std::uint32_t get(const HeaderBytes& bytes, std::size_t at) noexcept {
  std::uint32_t x = 0;
  for (std::size_t i = 0; i < 4; ++i) x |= std::uint32_t{bytes[at + i]} << (8 * i);
  return x;
}

bool all(const HeaderBytes& bytes, std::uint8_t value) noexcept {
  return std::all_of(bytes.begin(), bytes.end(), [value](std::uint8_t byte) { return byte == value; });
}

}  // namespace

HeaderBytes encode_header(const RecordHeader& header) noexcept {
  HeaderBytes bytes{};
  put(bytes, 0, kRecordMagic);
  put(bytes, 4, kRecordVersion);
  put(bytes, 8, header.generation);
  put(bytes, 12, header.length);
  put(bytes, 16, header.body_crc);
  put(bytes, 20, crc32(std::span(bytes).first(kVouchedBytes)));
  return bytes;
}

HeaderState decode_header(const HeaderBytes& bytes, RecordHeader& header) noexcept {
  if (all(bytes, 0x00) || all(bytes, 0xFF)) return HeaderState::blank;
  if (get(bytes, 0) != kRecordMagic || get(bytes, 4) != kRecordVersion) return HeaderState::damaged;
  if (get(bytes, 20) != crc32(std::span(bytes).first(kVouchedBytes))) return HeaderState::damaged;
  if (get(bytes, 12) > kMaxBodyBytes) return HeaderState::damaged;
  header = {.generation = get(bytes, 8), .length = get(bytes, 12), .body_crc = get(bytes, 16)};
  return HeaderState::good;
}

bool RowWriter::add(const RecordRow& row) noexcept {
  const std::size_t length = row.value.size();
  if (length > 0xFF || kRowHeaderBytes + length > body_.size() - size_) {
    overflowed_ = true;
    return false;
  }
  const std::span<std::uint8_t> to = body_.subspan(size_, kRowHeaderBytes + length);
  to[0] = static_cast<std::uint8_t>(row.index);
  to[1] = static_cast<std::uint8_t>(row.index >> 8);
  to[2] = row.sub;
  to[3] = static_cast<std::uint8_t>(length);
  std::copy(row.value.begin(), row.value.end(), to.begin() + kRowHeaderBytes);
  size_ += to.size();
  return true;
}

}  // namespace plenum::config
