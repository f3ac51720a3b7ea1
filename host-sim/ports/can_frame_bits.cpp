#include "host-sim/ports/can_frame_bits.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace plenum::host::ports {
namespace {

using plenum::ports::CanFrame;

constexpr std::uint16_t kPolynomial = 0x4599;

constexpr std::array<std::uint16_t, 256> make_crc_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte << 7;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x4000U) != 0 ? (crc << 1) ^ kPolynomial : crc << 1;
    table[byte] = static_cast<std::uint16_t>(crc & 0x7FFFU);
  }
  return table;
}
constexpr auto kCrcTable = make_crc_table();

/// Where the stuffing stands: the bit last sent, and how many of it in a row (1..4 between bits: five call
/// for a stuff bit at once, which starts a run of one). State = 4 * bit + run - 1.
struct Step {
  std::uint8_t state;
  std::uint8_t stuffed;
};

constexpr Step step(unsigned state, unsigned bit) {
  const unsigned last = state / 4;
  unsigned run = state % 4 + 1;
  if (bit != last) return {static_cast<std::uint8_t>(4 * bit), 0};
  ++run;
  if (run < 5) return {static_cast<std::uint8_t>(4 * bit + run - 1), 0};
  return {static_cast<std::uint8_t>(4 * (1 - bit)), 1};
}

/// The steps of `count` bits at once, most significant first. Which way a bit goes is as good as random: a
/// table costs a look-up where a branch a bit costs a misprediction for every second one.
template <unsigned count>
constexpr std::array<std::array<Step, 1U << count>, 8> make_stuff_table() {
  std::array<std::array<Step, 1U << count>, 8> table{};
  for (unsigned state = 0; state < 8; ++state) {
    for (unsigned bits = 0; bits < 1U << count; ++bits) {
      Step total{static_cast<std::uint8_t>(state), 0};
      for (unsigned i = count; i-- > 0;) {
        const Step one = step(total.state, (bits >> i) & 1U);
        total = {one.state, static_cast<std::uint8_t>(total.stuffed + one.stuffed)};
      }
      table[state][bits] = total;
    }
  }
  return table;
}
constexpr auto kStuffByte = make_stuff_table<8>();
constexpr auto kStuffTail = make_stuff_table<7>();  ///< what of the CRC does not fill a byte
// what of the header does not fill a byte, but for the start of frame
constexpr auto kStuffStandardHead = make_stuff_table<2>();
constexpr auto kStuffExtendedHead = make_stuff_table<6>();

}  // namespace

std::uint16_t crc15(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) crc = (crc << 8 ^ kCrcTable[(crc >> 7 ^ byte) & 0xFFU]) & 0x7FFFU;
  return static_cast<std::uint16_t>(crc);
}

unsigned frame_bits(const CanFrame& frame) {
  const unsigned length = std::min<unsigned>(frame.length, 8);
  const unsigned data_bytes = frame.remote ? 0 : length;
  const std::uint64_t remote = frame.remote ? 1 : 0;

  // The header right-aligned in whole bytes: the zeros before it leave a CRC that starts at zero as it is.
  const unsigned header_bits = frame.extended ? 39 : 19;
  const unsigned header_bytes = frame.extended ? 5 : 3;
  std::uint64_t header = 0;
  if (frame.extended) {
    const std::uint64_t base = (frame.id >> 18) & 0x7FFU;
    const std::uint64_t extension = frame.id & 0x3FFFFU;
    header =
        base << 27 | std::uint64_t{3} << 25 | extension << 7 | remote << 6 | length;  // SRR, IDE; r1, r0 = 0
  } else {
    header = std::uint64_t{frame.id & 0x7FFU} << 7 | remote << 6 | length;  // IDE, r0 = 0
  }
  std::array<std::uint8_t, 5 + 8 + 2> bytes{};
  std::size_t size = 0;
  for (unsigned i = header_bytes; i-- > 0;) bytes[size++] = static_cast<std::uint8_t>(header >> (8 * i));
  for (unsigned i = 0; i < data_bytes; ++i) bytes[size++] = frame.data[i];
  const unsigned crc = crc15(std::span(bytes.data(), size));
  bytes[size++] = static_cast<std::uint8_t>(crc >> 7);
  const unsigned tail = crc & 0x7FU;  // the last seven bits of the CRC

  constexpr unsigned kAfterStart = 0;  // a run of one dominant bit
  Step sent =
      frame.extended ? kStuffExtendedHead[kAfterStart][bytes[0]] : kStuffStandardHead[kAfterStart][bytes[0]];
  unsigned stuffed = sent.stuffed;
  for (std::size_t i = 1; i < size; ++i) {
    sent = kStuffByte[sent.state][bytes[i]];
    stuffed += sent.stuffed;
  }
  stuffed += kStuffTail[sent.state][tail].stuffed;

  return header_bits + 8 * data_bytes + 15 + stuffed + kTrailerBits;
}

}  // namespace plenum::host::ports
