// What the frames of all SDO transfers have in common. For the client's own sources.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::host::client::sdo {

inline constexpr std::size_t kSegmentBytes = 7;
inline constexpr std::uint8_t kToggleBit = 0x10;
inline constexpr std::uint8_t kAbort = 0x80;

constexpr std::uint8_t byte(unsigned value) {
  return static_cast<std::uint8_t>(value);
}

constexpr bool begins_block_download(std::uint8_t command) {
  return (command & 0xE1U) == 0xC0U;
}

/// The value in an initiate frame that carries it (expedited), of a request or of an answer.
constexpr std::span<const std::uint8_t> expedited(std::span<const std::uint8_t, 8> frame) {
  const bool is_sized = (frame[0] & 0x01U) != 0;
  return frame.subspan(4, is_sized ? 4U - ((frame[0] >> 2U) & 3U) : 4U);
}

/// Command and multiplexer; the last four bytes are zero.
constexpr std::array<std::uint8_t, 8> request(std::uint8_t command, std::uint16_t index, std::uint8_t sub) {
  return {command, byte(index & 0xFFU), byte(index >> 8U), sub, 0, 0, 0, 0};
}

}  // namespace plenum::host::client::sdo
