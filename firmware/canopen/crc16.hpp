// The CRC of SDO block transfers: CRC-16-CCITT, x^16 + x^12 + x^5 + 1, highest bit first, from 0 (CiA 301, 7.2.4.3.16).
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace plenum::canopen {

/// Continues `crc` over `bytes`. crc16 of "123456789" is 31C3h.
constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes, std::uint16_t crc = 0) noexcept {
  constexpr std::array<std::uint16_t, 16> kOfNibble = {0x0000, 0x1021, 0x2042, 0x3063, 0x4084, 0x50A5,
                                                       0x60C6, 0x70E7, 0x8108, 0x9129, 0xA14A, 0xB16B,
                                                       0xC18C, 0xD1AD, 0xE1CE, 0xF1EF};
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc << 4 ^ kOfNibble[(crc >> 12) ^ (byte >> 4)]);
    crc = static_cast<std::uint16_t>(crc << 4 ^ kOfNibble[(crc >> 12) ^ (byte & 0x0FU)]);
  }
  return crc;
}

}  // namespace plenum::canopen
