// The form of a scan: against bytes and offsets written by hand from the kernel's description, and numbers put in bit by bit.
#include "board/drivers/scan_format.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cstring>

namespace plenum::board::drivers {
namespace {

using ::testing::ElementsAre;

std::int64_t number(const char* type, const std::vector<std::uint8_t>& bytes) {
  std::vector<std::byte> stored(bytes.size());
  std::memcpy(stored.data(), bytes.data(), bytes.size());
  return raw_number(sample_format(type).value(), stored.data());
}

TEST(ScanFormat, ATypeIsReadAsTheKernelWritesIt) {
  EXPECT_EQ(sample_format("be:s16/16>>0"),
            (SampleFormat{.big_endian = true, .is_signed = true, .bits = 16, .storage_bits = 16}));
  EXPECT_EQ(sample_format("le:u12/32>>4"), (SampleFormat{.bits = 12, .storage_bits = 32, .shift = 4}));
  EXPECT_EQ(sample_format("le:u8/8"), (SampleFormat{.bits = 8, .storage_bits = 8}))
      << "a shift may be left out";
  EXPECT_EQ(sample_format("le:s16/16X3>>0"),
            (SampleFormat{.is_signed = true, .bits = 16, .storage_bits = 16, .repeat = 3}));
}

TEST(ScanFormat, ATypeOfAnotherFormIsNone) {
  for (const char* const type :
       {"", "be", "le:", "xe:s16/16>>0", "be:f32/32>>0", "be:16/16>>0", "be:s/16>>0", "be:s16", "be:s16/>>0",
        "be:s16/16>>", "be:s16/16X>>0", "be:s16/16>>0 ", "be:s-1/16>>0", "be:s16/99999999999>>0"})
    EXPECT_FALSE(sample_format(type).has_value()) << type;
}

TEST(ScanFormat, ANumberLiesWhollyInOneWordOf8Or16Or32Bits) {
  for (const char* const type : {"le:u1/8>>7", "be:s16/16>>0", "le:s24/32>>8", "le:u32/32>>0"})
    EXPECT_TRUE(sample_format(type).value().is_one_number()) << type;
  for (const char* const type : {"le:s64/64>>0", "le:s24/24>>0", "le:s16/16X2>>0", "le:s16/16X0>>0",
                                 "le:s0/16>>0", "le:s17/16>>0", "le:s12/16>>5", "le:s1/16>>4294967295"})
    EXPECT_FALSE(sample_format(type).value().is_one_number()) << type;
}

TEST(ScanFormat, ANumberIsItsBitsInTheirOrderOfBytes) {
  EXPECT_EQ(number("be:s16/16>>0", {0x12, 0x34}), 0x1234);
  EXPECT_EQ(number("le:s16/16>>0", {0x34, 0x12}), 0x1234);
  EXPECT_EQ(number("be:s16/16>>0", {0x80, 0x00}), -32768);
  EXPECT_EQ(number("be:u16/16>>0", {0x80, 0x00}), 32768);
  EXPECT_EQ(number("be:u12/16>>4", {0xAB, 0xCF}), 0xABC);
  EXPECT_EQ(number("le:s18/32>>2", {0x04, 0x00, 0x08, 0x00}), -131071);  // 20001h of 18 bits
  EXPECT_EQ(number("be:s24/32>>0", {0x55, 0xFF, 0xFF, 0xFE}), -2);
  EXPECT_EQ(number("le:u32/32>>0", {0x00, 0x00, 0x00, 0x80}), 2147483648);
  EXPECT_EQ(number("le:s32/32>>0", {0x00, 0x00, 0x00, 0x80}), -2147483648);
  EXPECT_EQ(number("le:s1/8>>3", {0x08}), -1);
}

RC_GTEST_PROP(ScanFormat, ANumberIsReadWhateverLiesAroundIt, ()) {
  const unsigned storage_bits = *rc::gen::element(8U, 16U, 32U);
  const unsigned bits = *rc::gen::inRange(1U, storage_bits + 1);
  const SampleFormat format{.big_endian = *rc::gen::arbitrary<bool>(),
                            .is_signed = *rc::gen::arbitrary<bool>(),
                            .bits = bits,
                            .storage_bits = storage_bits,
                            .shift = *rc::gen::inRange(0U, storage_bits - bits + 1)};
  const std::int64_t span = std::int64_t{1} << bits;
  const std::int64_t lowest = format.is_signed ? -span / 2 : 0;
  const std::int64_t put = *rc::gen::inRange(lowest, lowest + span);
  auto stored = *rc::gen::container<std::array<std::uint8_t, 4>>(rc::gen::arbitrary<std::uint8_t>());
  for (unsigned bit = 0; bit < bits; ++bit) {
    const unsigned place = bit + format.shift;
    std::uint8_t& byte = stored.at(format.big_endian ? storage_bits / 8 - 1 - place / 8 : place / 8);
    const auto mask = static_cast<std::uint8_t>(1U << place % 8);
    const bool is_one = (put < 0 ? put + span : put) / (std::int64_t{1} << bit) % 2 == 1;
    byte = static_cast<std::uint8_t>(is_one ? byte | mask : byte & ~mask);
  }
  RC_ASSERT(raw_number(format, reinterpret_cast<const std::byte*>(stored.data())) == put);
}

TEST(ScanFormat, ElementsStandByIndexAtMultiplesOfTheirSize) {
  // 16, 32 and 16 bits: two bytes are nobody's before the second, two after the third.
  const std::vector<ScanElement> mixed{
      {.index = 0, .bytes = 2}, {.index = 1, .bytes = 4}, {.index = 2, .bytes = 2}};
  EXPECT_THAT(scan_layout(mixed).offsets, ElementsAre(0, 4, 8));
  EXPECT_EQ(scan_layout(mixed).size, 12U);
  // The same, given in another order; an index may be left out.
  const std::vector<ScanElement> shuffled{
      {.index = 7, .bytes = 2}, {.index = 1, .bytes = 2}, {.index = 4, .bytes = 4}};
  EXPECT_THAT(scan_layout(shuffled).offsets, ElementsAre(8, 0, 4));
  EXPECT_EQ(scan_layout(shuffled).size, 12U);
}

TEST(ScanFormat, ElementsOfOneSizeLeaveNoHoles) {
  const std::vector<ScanElement> equal{
      {.index = 3, .bytes = 2}, {.index = 4, .bytes = 2}, {.index = 5, .bytes = 2}};
  EXPECT_THAT(scan_layout(equal).offsets, ElementsAre(0, 2, 4));
  EXPECT_EQ(scan_layout(equal).size, 6U);
  const std::vector<ScanElement> falling{
      {.index = 0, .bytes = 4}, {.index = 1, .bytes = 2}, {.index = 2, .bytes = 1}};
  EXPECT_THAT(scan_layout(falling).offsets, ElementsAre(0, 4, 6));
  EXPECT_EQ(scan_layout(falling).size, 8U);
}

}  // namespace
}  // namespace plenum::board::drivers
