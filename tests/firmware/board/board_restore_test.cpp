// Stored settings that this firmware does not admit: limits are never lost in silence, and never half.
#include <gtest/gtest.h>

#include <cstring>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

namespace object = canopen::object;

struct StoredValue {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::vector<std::uint8_t> bytes;
};

StoredValue real(std::uint16_t index, std::uint8_t sub, float value) {
  std::vector<std::uint8_t> bytes(4);
  std::memcpy(bytes.data(), &value, 4);
  return {index, sub, bytes};
}

config::Slots slots_with(const std::vector<StoredValue>& values) {
  std::vector<config::RecordRow> rows;
  for (const StoredValue& value : values)
    rows.push_back({.index = value.index, .sub = value.sub, .value = value.bytes});
  Bench writer;
  writer.store_models(Bench::images_of(1), rows);
  return writer.store.durable;
}

struct Restarted : Bench {
  explicit Restarted(const config::Slots& slots) {
    store = config::PowerCutMedium(slots);
    board.start();
    storing = true;
    tick();
  }
  float setting(std::uint16_t index, std::uint8_t sub) { return session.read<float>(index, sub); }
};

constexpr std::uint8_t kLow = 9, kHigh = 10, kOver = 11;  // of 2400h + c [kPa]; the bench's: 100, 600, 700

TEST(StoredSettings, RowThatIsNotAdmissibleIsAFaultAndItsChamberTakesNone) {
  const StoredValue fine = real(0x2400, kHigh, 250.0F);
  const std::vector<StoredValue> bad = {real(0x2400, kOver, 3000.0F),  // of its own range
                                        {0x2400, kOver, {0, 0}},       // of another size
                                        real(0x2400, 200, 1.0F),       // of a field that other firmware has
                                        {0x2408, 2, {0, 0}},          {0x2410, 1, {9}},
                                        real(0x2400, kOver, 240.0F)};  // contradicts the high limit
  for (const StoredValue& row : bad) {
    for (const bool first : {false, true}) {
      std::vector<StoredValue> rows = {fine, real(0x2401, kHigh, 260.0F), real(0x2418, 3, 450.0F)};
      rows.insert(first ? rows.begin() : rows.end(), row);
      Restarted board(slots_with(rows));
      SCOPED_TRACE(testing::Message() << std::hex << row.index << ':' << int{row.sub} << " first " << first);
      EXPECT_EQ(board.setting(0x2400, kHigh), 600.0F) << "the installer's";
      EXPECT_EQ(board.setting(0x2400, kOver), 700.0F);
      EXPECT_EQ(board.setting(0x2401, kHigh), 260.0F) << "another chamber's apply";
      EXPECT_EQ(board.setting(0x2418, 3), 450.0F) << "the board's, too";
      EXPECT_EQ(board.image().error_code, 0x6300);
      EXPECT_EQ(board.image().fault_chamber, 0);
      EXPECT_EQ(board.image().store.skipped_rows, 1);
      EXPECT_EQ(board.image().store.first_skipped >> 8, row.index);
    }
  }
}

TEST(StoredSettings, RowOfTheBoardThatIsNotAdmissibleIsAFaultAndTheBoardTakesNone) {
  for (const StoredValue& row : {real(0x2418, 1, 0.0F), StoredValue{0x2419, 1, {0, 0}}}) {
    Restarted board(slots_with({real(0x2418, 3, 450.0F), row, real(0x2401, kHigh, 260.0F)}));
    EXPECT_EQ(board.setting(0x2418, 3), 500.0F);
    EXPECT_EQ(board.setting(0x2401, kHigh), 260.0F);
    EXPECT_EQ(board.image().error_code, 0x6300);
  }
}

TEST(StoredSettings, FaultIsResetByTheOperatorAndGoneForGoodWithASave) {
  const config::Slots slots = slots_with({real(0x2400, kOver, 3000.0F)});
  Restarted board(slots);
  board.run(5);
  EXPECT_EQ(board.image().error_code, 0x6300) << "latched";
  board.session.write<std::uint16_t>(object::kControlWord, 0, 8);
  board.run(2);
  EXPECT_EQ(board.image().error_code, 0);
  EXPECT_EQ(Restarted(board.store.durable).image().error_code, 0x6300) << "with each start";
  board.session.write<float>(0x2400, kLow, 110.0F);
  board.session.write(object::kStore, 1, canopen::kSaveSignature);
  Restarted again(board.store.durable);
  EXPECT_EQ(again.image().error_code, 0);
  EXPECT_EQ(again.setting(0x2400, kLow), 110.0F);
}

}  // namespace
}  // namespace plenum
