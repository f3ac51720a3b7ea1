#include "firmware/config/parameter_record.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace plenum::config {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

// Written by hand from the table; the CRC-32 of the first twenty bytes is zlib's.
constexpr HeaderBytes kByHand = {'P',  'L',  'S',  '1',  1,    0,    0,    0,    0x04, 0x03, 0x02, 0x01,
                                 0x10, 0x00, 0x00, 0x00, 0xDD, 0xCC, 0xBB, 0xAA, 0x70, 0xF7, 0xD6, 0x91};
constexpr RecordHeader kHeader{.generation = 0x01020304, .length = 16, .body_crc = 0xAABBCCDD};

TEST(RecordHeader, StandsAsTheTableSays) {
  EXPECT_THAT(encode_header(kHeader), ElementsAreArray(kByHand));
  RecordHeader read;
  ASSERT_EQ(decode_header(kByHand, read), HeaderState::good);
  EXPECT_EQ(read.generation, kHeader.generation);
  EXPECT_EQ(read.length, kHeader.length);
  EXPECT_EQ(read.body_crc, kHeader.body_crc);
}

TEST(RecordHeader, IsBlankOnlyWhereNothingWasEverWritten) {
  HeaderBytes bytes{};
  RecordHeader read;
  EXPECT_EQ(decode_header(bytes, read), HeaderState::blank);
  bytes[7] = 1;
  EXPECT_EQ(decode_header(bytes, read), HeaderState::damaged);
  bytes.fill(0xFF);
  EXPECT_EQ(decode_header(bytes, read), HeaderState::blank);
  bytes[23] = 0xFE;
  EXPECT_EQ(decode_header(bytes, read), HeaderState::damaged);
}

TEST(RecordHeader, IsDamagedByAnySingleBitAndByAnyPrefix) {
  RecordHeader read{.generation = 77, .length = 0, .body_crc = 0};
  for (std::size_t bit = 0; bit < 8 * kRecordHeaderBytes; ++bit) {
    HeaderBytes bytes = kByHand;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    ASSERT_EQ(decode_header(bytes, read), HeaderState::damaged) << "bit " << bit;
  }
  for (std::size_t kept = 1; kept < kRecordHeaderBytes; ++kept) {
    HeaderBytes bytes{};
    std::copy_n(kByHand.begin(), kept, bytes.begin());
    ASSERT_EQ(decode_header(bytes, read), HeaderState::damaged) << kept << " bytes";
  }
  EXPECT_EQ(read.generation, 77U) << "written for a header that is none";
}

TEST(RecordHeader, OfALengthThatNoBodyHasIsDamagedForAllItsCrc) {
  RecordHeader read;
  EXPECT_EQ(decode_header(encode_header({.generation = 1, .length = kMaxBodyBytes, .body_crc = 0}), read),
            HeaderState::good);
  EXPECT_EQ(decode_header(encode_header({.generation = 1, .length = kMaxBodyBytes + 1, .body_crc = 0}), read),
            HeaderState::damaged);
}

TEST(Generation, IsComparedAcrossItsWrapAround) {
  EXPECT_TRUE(is_newer(2, 1));
  EXPECT_FALSE(is_newer(1, 2));
  EXPECT_FALSE(is_newer(5, 5));
  EXPECT_TRUE(is_newer(0, 0xFFFF'FFFF));
  EXPECT_FALSE(is_newer(0xFFFF'FFFF, 0));
  EXPECT_TRUE(is_newer(0x7FFF'FFFF, 0));
  EXPECT_FALSE(is_newer(0x8000'0001, 0));
}

TEST(RecordRows, StandAsTheTableSaysAndComeBackInOrder) {
  std::vector<std::uint8_t> body(64, 0xEE);
  RowWriter writer(body);
  const std::vector<std::uint8_t> one{9}, three{1, 2, 3};
  ASSERT_TRUE(writer.add({.index = 0x1017, .sub = 0, .value = three}));
  ASSERT_TRUE(writer.add({.index = 0x6380, .sub = 1, .value = {}}));
  ASSERT_TRUE(writer.add({.index = 0x2118, .sub = 2, .value = one}));
  body.resize(writer.size());
  EXPECT_THAT(body, ElementsAre(0x17, 0x10, 0, 3, 1, 2, 3, 0x80, 0x63, 1, 0, 0x18, 0x21, 2, 1, 9));

  RowReader reader(body);
  RecordRow row;
  ASSERT_TRUE(reader.next(row));
  EXPECT_EQ(row.index, 0x1017);
  EXPECT_THAT(row.value, ElementsAre(1, 2, 3));
  ASSERT_TRUE(reader.next(row));
  EXPECT_TRUE(row.value.empty());
  ASSERT_TRUE(reader.next(row));
  EXPECT_EQ(row.sub, 2);
  EXPECT_FALSE(reader.next(row));
}

TEST(RecordRows, ThatDoNotFitAreNotWrittenByHalf) {
  std::vector<std::uint8_t> body(10, 0xEE);
  RowWriter writer(body);
  const std::vector<std::uint8_t> value(7, 1), long_value(256, 1);
  EXPECT_FALSE(writer.add({.index = 1, .sub = 0, .value = value}));
  EXPECT_EQ(writer.size(), 0U);
  EXPECT_TRUE(writer.overflowed());
  EXPECT_THAT(body, ::testing::Each(0xEE));
  EXPECT_TRUE(writer.add({.index = 1, .sub = 0, .value = std::span(value).first(6)}));
  EXPECT_FALSE(writer.add({}));
  std::vector<std::uint8_t> wide(1000);
  RowWriter wide_writer(wide);
  EXPECT_FALSE(wide_writer.add({.index = 1, .sub = 0, .value = long_value}));
}

TEST(RecordRows, EndAtARowThatTheBodyCutsOff) {
  const std::vector<std::uint8_t> body{0x17, 0x10, 0, 3, 1, 2, 3};
  for (std::size_t size = 0; size < body.size(); ++size) {
    RowReader reader({body.data(), size});
    RecordRow row;
    EXPECT_FALSE(reader.next(row)) << size << " bytes";
  }
}

}  // namespace
}  // namespace plenum::config
