// CRC-32 of IEEE 802.3 (polynomial 04C11DB7h reflected), as zlib and Ethernet have it.
// Check value CBF43926h for "123456789".
#pragma once

#include <cstdint>
#include <span>

namespace plenum::config {

/// `before`: the CRC of the bytes that come before these, where a message is handed over in parts.
std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before = 0) noexcept;

}  // namespace plenum::config
