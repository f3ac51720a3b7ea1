#include "firmware/telemetry/recorder.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <string>
#include <vector>

#include "firmware/config/crc32.hpp"

namespace plenum::telemetry {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// What chamber c holds at tick k: told apart in every column.
Recorder::Samples samples_of(std::uint32_t tick) {
  Recorder::Samples samples;
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    const auto x = static_cast<float>(tick) + 0.125F * static_cast<float>(c);
    samples[c] = {
        .pressure_Pa = 100000.0F + x, .volume_m3 = 1e-4F + x * 1e-9F, .command_V = 5.0F, .measured = true};
  }
  return samples;
}

void run(Recorder& recorder, std::uint32_t first, std::uint32_t last) {
  for (std::uint32_t tick = first; tick <= last; ++tick) recorder.write(tick, false, samples_of(tick));
}

Bytes read_all(Recorder& recorder, std::size_t at_once) {
  Bytes bytes;
  Bytes part(at_once);
  for (;;) {
    const std::size_t count = recorder.read(static_cast<std::uint32_t>(bytes.size()), part);
    if (count == 0) return bytes;
    bytes.insert(bytes.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(count));
  }
}

std::uint32_t u32_at(const Bytes& bytes, std::size_t at) {
  return bytes.at(at) | static_cast<std::uint32_t>(bytes.at(at + 1)) << 8 |
         static_cast<std::uint32_t>(bytes.at(at + 2)) << 16 |
         static_cast<std::uint32_t>(bytes.at(at + 3)) << 24;
}

constexpr auto kFreeze = static_cast<std::uint8_t>(Recorder::Order::freeze);
constexpr auto kRecord = static_cast<std::uint8_t>(Recorder::Order::record);
constexpr auto kRoll = static_cast<std::uint8_t>(Recorder::Order::roll);

TEST(Recorder, RollsFromTheStartAndKeepsTheLastTicks) {
  Recorder recorder;
  EXPECT_EQ(recorder.state(), Recorder::State::rolling);
  run(recorder, 1, 3000);
  EXPECT_EQ(recorder.rows(), kLogTicks);
  EXPECT_EQ(recorder.end() - recorder.begin(), kLogTicks);
  EXPECT_FLOAT_EQ(recorder.row(recorder.end() - 1, 0).pressure_kPa, 1e-3F * 103000.0F);
  EXPECT_FLOAT_EQ(recorder.row(recorder.begin(), 4).pressure_kPa,
                  1e-3F * (100000.0F + 3000.0F - 1023.0F + 0.5F));
}

TEST(Recorder, MarksARowThatDoesNotFollowTheOneBeforeIt) {
  Recorder recorder;
  recorder.write(7, false, samples_of(7));
  recorder.write(8, false, samples_of(8));
  recorder.write(10, false, samples_of(10));
  EXPECT_FALSE(recorder.row(0, 0).has(row_flag::kFollows)) << "the first row follows none";
  EXPECT_TRUE(recorder.row(1, 0).has(row_flag::kFollows));
  EXPECT_FALSE(recorder.row(2, 0).has(row_flag::kFollows)) << "tick 9 was not driven";
}

TEST(Recorder, MarksWhatWasMeasuredAndWhatWasExcited) {
  Recorder recorder;
  Recorder::Samples samples = samples_of(1);
  samples[3].measured = false;
  recorder.write(1, true, samples);
  EXPECT_FALSE(recorder.row(0, 3).has(row_flag::kMeasured));
  EXPECT_TRUE(recorder.row(0, 4).has(row_flag::kMeasured));
  EXPECT_TRUE(recorder.row(0, 3).has(row_flag::kExcited));
}

TEST(Recorder, RecordsTheTicksAskedForAndFreezes) {
  Recorder recorder;
  run(recorder, 1, 50);
  ASSERT_TRUE(recorder.set_length(20));
  ASSERT_TRUE(recorder.order(kRecord));
  EXPECT_EQ(recorder.rows(), 0) << "what was there is forgotten";
  run(recorder, 51, 69);
  EXPECT_EQ(recorder.state(), Recorder::State::recording);
  EXPECT_FALSE(recorder.set_length(10)) << "not while it records";
  run(recorder, 70, 200);
  EXPECT_EQ(recorder.state(), Recorder::State::frozen);
  EXPECT_EQ(recorder.rows(), 20);
  EXPECT_FLOAT_EQ(recorder.row(recorder.begin(), 0).pressure_kPa, 1e-3F * 100051.0F);
  EXPECT_FLOAT_EQ(recorder.row(recorder.end() - 1, 0).pressure_kPa, 1e-3F * 100070.0F);
}

TEST(Recorder, TakesARecordingOfTheWholeRing) {
  Recorder recorder;
  ASSERT_TRUE(recorder.set_length(kLogTicks));
  ASSERT_TRUE(recorder.order(kRecord));
  run(recorder, 1, kLogTicks - 1);
  EXPECT_EQ(recorder.state(), Recorder::State::recording);
  run(recorder, kLogTicks, kLogTicks);
  EXPECT_EQ(recorder.state(), Recorder::State::frozen);
}

TEST(Recorder, KeepsAFrozenLogAsItIs) {
  Recorder recorder;
  run(recorder, 1, 100);
  ASSERT_TRUE(recorder.order(kFreeze));
  const Bytes before = read_all(recorder, 100);
  run(recorder, 101, 300);
  EXPECT_EQ(read_all(recorder, 100), before);
  ASSERT_TRUE(recorder.order(kRoll));
  run(recorder, 301, 301);
  EXPECT_EQ(recorder.rows(), 101) << "rolls on from what it held";
  EXPECT_FALSE(recorder.row(recorder.end() - 1, 0).has(row_flag::kFollows));
}

TEST(Recorder, GivesNoByteOfALogThatGoesOn) {
  Recorder recorder;
  run(recorder, 1, 10);
  Bytes bytes(8, 0xAA);
  EXPECT_EQ(recorder.read(0, bytes), 0U);
  ASSERT_TRUE(recorder.order(kRecord));
  EXPECT_EQ(recorder.read(0, bytes), 0U);
  EXPECT_EQ(bytes, Bytes(8, 0xAA));
}

TEST(Recorder, RefusesOrdersChambersAndLengthsThatAreNone) {
  Recorder recorder;
  EXPECT_FALSE(recorder.order(3));
  EXPECT_FALSE(recorder.select(8));
  EXPECT_FALSE(recorder.set_length(0));
  EXPECT_FALSE(recorder.set_length(kLogTicks + 1));
  EXPECT_EQ(recorder.last_order(), kRoll);
  EXPECT_EQ(recorder.selected(), 0);
  EXPECT_EQ(recorder.length(), kLogTicks);
}

// 300,000 Pa = 48927C00h; 1 / 4096 m3 = 39800000h; 2.5 V is code 16383.75, nearest 16384 = 4000h.
TEST(Recorder, WritesTheLogAsItsLayoutSays) {
  Recorder recorder;
  Recorder::Samples samples;
  samples[2] = {.pressure_Pa = 300000.0F, .volume_m3 = 1.0F / 4096.0F, .command_V = 2.5F, .measured = true};
  recorder.write(0x01020304, true, samples);
  samples[2].command_V = 11.0F;  // beyond the code's end
  samples[2].measured = false;
  recorder.write(0x01020305, true, samples);
  ASSERT_TRUE(recorder.select(2));
  ASSERT_TRUE(recorder.order(kFreeze));
  const Bytes log = read_all(recorder, 1000);
  const Bytes expected = {
      'P',  'L',  'L',  '1',  0x05, 0x03, 0x02, 0x01,
      2,    0,    2,    12,                            // magic, tick, rows, chamber, size
      0x0A, 0xD7, 0x23, 0x3C, 0xA0, 0x00, 0x20, 0x39,  // 0.01 s, 10 V / 65535
      0x00, 0x7C, 0x92, 0x48, 0x00, 0x00, 0x80, 0x39,
      0x00, 0x40, 0x05, 0x00,  // measured, excited
      0x00, 0x7C, 0x92, 0x48, 0x00, 0x00, 0x80, 0x39,
      0xFF, 0xFF, 0x06, 0x00,  // follows, excited
  };
  ASSERT_EQ(log.size(), expected.size() + 4);
  EXPECT_EQ(Bytes(log.begin(), log.end() - 4), expected);
  EXPECT_EQ(u32_at(log, expected.size()), config::crc32(expected));
  EXPECT_EQ(recorder.size(), log.size());
}

TEST(Recorder, GivesTheSameBytesInPartsOfAnySize) {
  Recorder recorder;
  run(recorder, 1, 1100);
  ASSERT_TRUE(recorder.order(kFreeze));
  const Bytes whole = read_all(recorder, 20000);
  ASSERT_EQ(whole.size(), 20U + 12U * 1024U + 4U);
  EXPECT_EQ(u32_at(whole, whole.size() - 4), config::crc32(std::span(whole).first(whole.size() - 4)));
  for (const std::size_t at_once : {1U, 5U, 7U, 12U, 13U, 127U * 7U}) {
    ASSERT_TRUE(recorder.order(kFreeze));
    EXPECT_EQ(read_all(recorder, at_once), whole) << at_once << " bytes at once";
  }
}

// A block transfer that lost a segment is sent again from the block's first byte.
TEST(Recorder, GivesABlockAgain) {
  Recorder recorder;
  run(recorder, 1, 200);
  ASSERT_TRUE(recorder.order(kFreeze));
  const Bytes whole = read_all(recorder, 20000);
  ASSERT_TRUE(recorder.order(kFreeze));
  Bytes block(889);
  ASSERT_EQ(recorder.read(0, block), 889U);
  ASSERT_EQ(recorder.read(889, block), 889U);
  ASSERT_EQ(recorder.read(889, block), 889U);
  EXPECT_EQ(block, Bytes(whole.begin() + 889, whole.begin() + 1778));
  EXPECT_EQ(recorder.read(1778, block), whole.size() - 1778);
  EXPECT_EQ(Bytes(block.begin(), block.begin() + static_cast<std::ptrdiff_t>(whole.size() - 1778)),
            Bytes(whole.begin() + 1778, whole.end()));
}

TEST(Recorder, GivesEachChamberItsOwnLog) {
  Recorder recorder;
  run(recorder, 1, 5);
  ASSERT_TRUE(recorder.order(kFreeze));
  for (std::uint8_t c = 0; c < config::kChambers; ++c) {
    ASSERT_TRUE(recorder.select(c));
    const Bytes log = read_all(recorder, 7);
    EXPECT_EQ(log.at(10), c);
    EXPECT_EQ(std::bit_cast<float>(u32_at(log, 20)), 100001.0F + 0.125F * static_cast<float>(c));
    EXPECT_EQ(u32_at(log, log.size() - 4), config::crc32(std::span(log).first(log.size() - 4)));
  }
}

TEST(Recorder, AnEmptyLogIsAHeaderAndItsCrc) {
  Recorder recorder;
  ASSERT_TRUE(recorder.order(kFreeze));
  const Bytes log = read_all(recorder, 3);
  EXPECT_EQ(log.size(), 24U);
  EXPECT_EQ(log.at(8), 0);
}

TEST(Columns, LieOneAfterTheOtherAndFillARow) {
  std::size_t at = 0;
  for (const Column& column : columns()) {
    EXPECT_EQ(column.offset, at) << column.name;
    at += column.bytes;
    const std::string name = column.name, unit = column.unit;
    if (!unit.empty()) {
      EXPECT_TRUE(name.ends_with("_" + unit)) << name << " in " << unit;
    }
  }
  EXPECT_EQ(at, 12U);
}

}  // namespace
}  // namespace plenum::telemetry
