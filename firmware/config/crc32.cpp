#include "firmware/config/crc32.hpp"

#include <array>

namespace plenum::config {
namespace {

constexpr std::uint32_t kPolynomial = 0xEDB88320U;  // 04C11DB7h, bits reversed

// One entry a nibble: 64 bytes of table instead of 1 KiB, two look-ups a byte.
constexpr std::array<std::uint32_t, 16> nibble_table() {
  std::array<std::uint32_t, 16> table{};
  for (std::uint32_t nibble = 0; nibble < 16; ++nibble) {
    std::uint32_t remainder = nibble;
    for (int bit = 0; bit < 4; ++bit) {
      remainder = (remainder >> 1) ^ ((remainder & 1U) != 0 ? kPolynomial : 0U);
    }
    table[nibble] = remainder;
  }
  return table;
}

constexpr std::array<std::uint32_t, 16> kNibble = nibble_table();

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before) noexcept {
  std::uint32_t remainder = ~before;
  for (const std::uint8_t byte : bytes) {
    remainder ^= byte;
    remainder = (remainder >> 4) ^ kNibble[remainder & 0xFU];
    remainder = (remainder >> 4) ^ kNibble[remainder & 0xFU];
  }
  return ~remainder;
}

}  // namespace plenum::config
