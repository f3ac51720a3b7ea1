// Lengths of CAN frames against counts made by hand and against a bit-by-bit transcription of ISO 11898-1.
#include "host-sim/ports/can_frame_bits.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <string_view>
#include <vector>

namespace plenum::host::ports {
namespace {

using plenum::ports::CanFrame;

/// The frame as the standard draws it: one int a bit, CRC by the shift register of its 10.4.2.6, stuffing by
/// its 10.5.
unsigned bits_by_the_book(const CanFrame& frame) {
  std::vector<int> bits{0};
  const auto append = [&bits](std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) bits.push_back(static_cast<int>(value >> i & 1U));
  };
  if (frame.extended) {
    append(frame.id >> 18, 11);
    append(3, 2);
    append(frame.id & 0x3FFFFU, 18);
    append(frame.remote ? 1 : 0, 1);
    append(0, 2);
  } else {
    append(frame.id, 11);
    append(frame.remote ? 1 : 0, 1);
    append(0, 2);
  }
  append(frame.length, 4);
  if (!frame.remote) {
    for (std::size_t i = 0; i < frame.length; ++i) append(frame.data[i], 8);
  }
  unsigned crc = 0;
  for (const int bit : bits) {
    const bool invert = static_cast<unsigned>(bit) != (crc >> 14 & 1U);
    crc = crc << 1 & 0x7FFFU;
    if (invert) crc ^= 0x4599U;
  }
  append(crc, 15);
  unsigned sent = 0;
  int last = -1;
  int run = 0;
  for (const int bit : bits) {
    ++sent;
    run = bit == last ? run + 1 : 1;
    last = bit;
    if (run == 5) {
      ++sent;
      last = 1 - bit;
      run = 1;
    }
  }
  return sent + 1 + 2 + 7;
}

CanFrame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
  CanFrame frame;
  frame.id = id;
  for (const std::uint8_t byte : data) frame.data[frame.length++] = byte;
  return frame;
}

TEST(CanCrc, HasTheCatalogueCheckValue) {
  constexpr std::string_view text = "123456789";
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  EXPECT_EQ(crc15(bytes), 0x059E);
}

// All 34 bits from the start of frame to the CRC (that of zeros is zero) are dominant: a stuff bit after each
// fifth (a recessive stuff bit starts the count anew) makes 6, and the trailer has 10.
TEST(CanFrameBits, OfTheAllZeroFrameAreCountedByHand) {
  EXPECT_EQ(frame_bits(frame_of(0, {})), 34U + 6U + 10U);
}

// 0 | 000 0000 0000 | 0 0 0 | 0001 | 0000 0001 and the CRC of x^8 + 1 (the length code stands eight bits
// above the data's one): x^15 (x^8 + 1) mod x^15+x^14+x^10+x^8+x^7+x^4+x^3+1. x^15 = 4599h; times x^8 by
// eight shifts: 4599, 4EAB, 58CF, 7407, 2D97, 5B2E, 73C5, 2213, 4426; sum 4426 ^ 4599 = 01BFh = 000 0001 1011
// 1111. Stuff bits: after the 5th, 10th and 15th zero of the first 18 (three zeros left, then the 1), after
// five of the seven zeros between the ones (two left), after the 5th of the CRC's first six zeros, after the
// 5th of its last six ones.
TEST(CanFrameBits, OfOneByteAreCountedByHand) {
  const std::array<std::uint8_t, 4> header_and_data{0x00, 0x00, 0x01, 0x01};
  EXPECT_EQ(crc15(header_and_data), 0x01BF);
  EXPECT_EQ(frame_bits(frame_of(0, {0x01})), 19U + 8U + 15U + 6U + 10U);
}

TEST(CanFrameBits, OfRemoteFramesLeaveTheDataOut) {
  CanFrame frame = frame_of(0x123, {1, 2, 3, 4, 5, 6, 7, 8});
  frame.remote = true;
  EXPECT_EQ(frame_bits(frame), bits_by_the_book(frame));
  EXPECT_LT(frame_bits(frame), 60U);
}

RC_GTEST_PROP(CanFrameBits, AgreeWithTheBookAndStayWithinItsBounds, ()) {
  CanFrame frame;
  frame.extended = *rc::gen::arbitrary<bool>();
  frame.remote = *rc::gen::weightedElement<bool>({{9, false}, {1, true}});
  frame.id = *rc::gen::inRange<std::uint32_t>(0, frame.extended ? 0x20000000U : 0x800U);
  frame.length = *rc::gen::inRange<std::uint8_t>(0, 9);
  if (!frame.remote) {
    const bool runs = *rc::gen::arbitrary<bool>();  // long runs of equal bits are what stuffing is about
    for (std::size_t i = 0; i < frame.length; ++i) {
      frame.data[i] = runs ? *rc::gen::element<std::uint8_t>(0x00, 0xFF, 0x0F, 0xF0, 0x83, 0x07)
                           : *rc::gen::arbitrary<std::uint8_t>();
    }
  }
  const unsigned bits = frame_bits(frame);
  RC_ASSERT(bits == bits_by_the_book(frame));
  const unsigned stuffable = (frame.extended ? 54U : 34U) + (frame.remote ? 0U : 8U * frame.length);
  RC_ASSERT(bits >= stuffable + kTrailerBits);
  RC_ASSERT(bits <= most_frame_bits(frame));
}

TEST(CanFrameBits, AtMostAreThoseOfTheResponseTimeAnalysis) {
  // Davis, Burns, Bril and Lukkien (2007), Eq. 2 and 3, intermission included: 55 + 10 s and 80 + 10 s bits
  for (std::uint8_t s = 0; s <= 8; ++s) {
    EXPECT_EQ(most_frame_bits({.length = s}) + kIntermissionBits, 55U + 10U * s);
    EXPECT_EQ(most_frame_bits({.length = s, .extended = true}) + kIntermissionBits, 80U + 10U * s);
  }
}

TEST(ArbitrationKey, PutsLowIdentifiersDataFramesAndShortIdentifiersFirst) {
  const auto key = [](std::uint32_t id, bool extended, bool remote) {
    return arbitration_key({.id = id, .extended = extended, .remote = remote});
  };
  EXPECT_LT(key(0x080, false, false), key(0x081, false, false));
  EXPECT_LT(key(0x080, false, false), key(0x080, false, true));
  EXPECT_LT(key(0x080, false, true), key(0x080U << 18, true, false))
      << "the IDE bit decides after equal SRR and RTR";
  EXPECT_LT(key(0x080U << 18, true, false), key((0x080U << 18) + 1, true, false));
  EXPECT_LT(key(0x080U << 18, true, false), key(0x080U << 18, true, true));
  EXPECT_LT(key((0x080U << 18) + 0x3FFFF, true, true), key(0x081, false, false));
}

}  // namespace
}  // namespace plenum::host::ports
