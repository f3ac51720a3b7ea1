// How long a classic CAN frame is on the wire, bit by bit (ISO 11898-1).
//
//   SOF 1 | identifier 11 or 29 with its flags | DLC 4 | data 8 n | CRC 15     stuffed: after five equal bits
//   an opposite one CRC delimiter 1 | ACK slot 1 | ACK delimiter 1 | EOF 7 | intermission 3    not stuffed
//
// The count is that of the very frame: its CRC is computed and its stuff bits are counted, none is assumed.
// Source: ISO 11898-1:2015, 10.4 (frame formats), 10.5 (bit stuffing); CRC-15/CAN, polynomial 4599h.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/ports/can_bus.hpp"

namespace plenum::host::ports {

inline constexpr unsigned kTrailerBits = 10;      ///< CRC delimiter, ACK slot and delimiter, end of frame
inline constexpr unsigned kIntermissionBits = 3;  ///< between two frames

/// CRC-15/CAN of whole bytes; check value 059Eh for "123456789".
std::uint16_t crc15(std::span<const std::uint8_t> bytes);

/// Bits from the start of frame to the end of frame, stuff bits included, intermission not.
unsigned frame_bits(const plenum::ports::CanFrame& frame);

/// The most that a frame of this form and length can have: its first stuff bit after five equal bits, each further one
/// after four, over all that is stuffed.
constexpr unsigned most_frame_bits(const plenum::ports::CanFrame& frame) {
  const unsigned data_bytes = frame.remote ? 0U : frame.length < 8 ? frame.length : 8U;
  const unsigned stuffed = (frame.extended ? 39U : 19U) + 8 * data_bytes + 15;
  return stuffed + (stuffed - 1) / 4 + kTrailerBits;
}

/// The order in which frames win arbitration: the lower key wins. Equal keys collide.
constexpr std::uint32_t arbitration_key(const plenum::ports::CanFrame& frame) {
  const std::uint32_t remote = frame.remote ? 1 : 0;
  if (!frame.extended) return frame.id << 21 | remote << 20;
  // a 29-bit frame sends its upper 11 bits first, then two recessive bits (SRR, IDE)
  return (frame.id >> 18) << 21 | 1U << 20 | 1U << 19 | (frame.id & 0x3FFFFU) << 1 | remote;
}

}  // namespace plenum::host::ports
