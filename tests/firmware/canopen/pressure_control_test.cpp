// CiA 408: identity of the device, and transducer and pressure control of each chamber, as a master of that profile sees them.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <string>

#include "firmware/canopen/object_dictionary.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

using Indices = std::initializer_list<std::uint16_t>;

constexpr auto kRangeAbort = static_cast<std::uint32_t>(Abort::value_range);
constexpr auto kTooHigh = static_cast<std::uint32_t>(Abort::value_too_high);
constexpr auto kTooLow = static_cast<std::uint32_t>(Abort::value_too_low);
constexpr auto kReadOnly = static_cast<std::uint32_t>(Abort::read_only);

/// A board in INIT, and the SDOs of a master.
struct Master : Bench {
  Master() { image.status_word = 0x8; }

  std::string exchange(unsigned command, std::uint16_t index, unsigned sub, std::uint32_t data) {
    char frame[64];
    std::snprintf(frame, sizeof frame, "605 %02X %02X %02X %02X %02X %02X %02X %02X", command, index & 0xFFU,
                  unsigned{index} >> 8U, sub, data & 0xFFU, data >> 8U & 0xFFU, data >> 16U & 0xFFU,
                  data >> 24U);
    return answer(frame);
  }
  static std::uint32_t data_of(const std::string& response) {
    std::uint32_t data = 0;
    for (unsigned i = 0; i < 4; ++i)
      data |= static_cast<std::uint32_t>(std::stoul(response.substr(16 + 3 * i, 2), nullptr, 16)) << 8U * i;
    return data;
  }

  std::uint32_t read(std::uint16_t index, unsigned sub) {
    const std::string response = exchange(0x40, index, sub, 0);
    EXPECT_EQ(response.substr(4, 1), "4") << "an expedited answer: " << response;
    return data_of(response);
  }
  int read_16(std::uint16_t index, unsigned sub = 1) { return static_cast<std::int16_t>(read(index, sub)); }

  /// The abort code, or 0.
  std::uint32_t write(std::uint16_t index, unsigned sub, int value, unsigned bytes) {
    const std::string response =
        exchange(0x23U | (4 - bytes) << 2U, index, sub,
                 static_cast<std::uint32_t>(value) & (0xFFFFFFFFU >> 8U * (4 - bytes)));
    return response.substr(4, 2) == "60" ? 0 : data_of(response);
  }
  std::uint32_t write_16(std::uint16_t index, int value) { return write(index, 1, value, 2); }
  std::uint32_t write_8(std::uint16_t index, int value) { return write(index, 0, value, 1); }

  std::string text(std::uint16_t index) {
    const std::string first = exchange(0x40, index, 0, 0);
    if (first.substr(4, 2) == "80") return "aborted";
    std::string text;
    if ((std::stoul(first.substr(4, 2), nullptr, 16) & 2U) != 0) {  // expedited
      const unsigned count =
          4 - (static_cast<unsigned>(std::stoul(first.substr(4, 2), nullptr, 16)) >> 2U & 3U);
      for (unsigned i = 0; i < count; ++i)
        text += static_cast<char>(std::stoul(first.substr(16 + 3 * i, 2), nullptr, 16));
      return text;
    }
    for (unsigned toggle = 0;; toggle ^= 0x10U) {
      char frame[64];
      std::snprintf(frame, sizeof frame, "605 %02X 00 00 00 00 00 00 00", 0x60U | toggle);
      const std::string segment = answer(frame);
      const auto command = static_cast<unsigned>(std::stoul(segment.substr(4, 2), nullptr, 16));
      for (unsigned i = 0; i < 7 - (command >> 1U & 7U); ++i)
        text += static_cast<char>(std::stoul(segment.substr(7 + 3 * i, 2), nullptr, 16));
      if ((command & 1U) != 0) return text;
    }
  }

  const config::ChamberSettings& chamber(unsigned c) const { return settings.chamber(c); }
};

TEST(DeviceIdentity, GivesTheNumbersOf1018hInWords) {
  Master master;
  EXPECT_EQ(master.text(0x6050), master.text(0x100A));
  EXPECT_EQ(master.text(0x6051), std::to_string(master.read(0x1018, 2)));
  EXPECT_EQ(master.text(0x6052), std::to_string(master.read(0x1018, 4)));
  EXPECT_EQ(master.text(0x6053), "Regulates the pressure of eight pneumatic chambers");
  EXPECT_EQ(master.exchange(0x40, 0x6055, 0, 0), "585 80 55 60 00 24 00 00 08")
      << "no data: no page is stated";
  EXPECT_EQ(master.read(0x605F, 0), 0b11000U) << "control modes 3 and 4";
}

TEST(DeviceIdentity, HasAMarkForTheSetOfParametersThatIsStored) {
  Master master;
  EXPECT_EQ(master.read(0x6056, 0), 0U);
  EXPECT_EQ(master.write(0x6056, 0, 0x12345678, 4), 0U);
  EXPECT_EQ(master.read(0x6056, 0), 0x12345678U);
  EXPECT_EQ(find(0x6056, 0).entry->kept, Kept::application);
  master.send("000 81 05");
  master.tick(20);
  master.drain();
  EXPECT_EQ(master.read(0x6056, 0), 0U) << "not saved";
}

TEST(PressureControl, NamesItsUnits) {
  Master master;
  struct Unit {
    std::uint16_t index;
    unsigned unit, prefix;
  };
  for (const Unit& of : {Unit{0x6120, 0x4E, 0xFD},
                         {0x6124, 0x26, 0xFD},
                         {0x6125, 0x26, 0xFD},
                         {0x6382, 0x4E, 0xFD},
                         {0x6390, 0x4E, 0xFD},
                         {0x6391, 0x4E, 0xFD},
                         {0x63A3, 0x4E, 0xFD},
                         {0x63B1, 0x03, 0xFD},
                         {0x63B6, 0x03, 0xFD},
                         {0x63D0, 0x4E, 0xFD},
                         {0x63D2, 0x03, 0xFD},
                         {0x63D5, 0x4E, 0xFD},
                         {0x63E1, 0x26, 0xFD},
                         {0x63E2, 0x20, 0x00},
                         {0x63F1, 0x03, 0xFD},
                         {0x63F2, 0x4E, 0xFD}}) {
    for (const unsigned chamber : {0U, 7U}) {
      const std::uint16_t index = object::of_module(of.index, chamber);
      EXPECT_EQ(master.read(index, 0) & 0xFFU, 3U) << index;
      EXPECT_EQ(master.read(index, 2) & 0xFFU, of.unit) << index;
      EXPECT_EQ(master.read(index, 3) & 0xFFU, of.prefix) << index;
    }
  }
}

// 100 kPa/V from 0.2 to 9.9 V
TEST(Transducer, ShowsTheLineOfTheSensorByTheEndsOfItsWindow) {
  Master master;
  EXPECT_EQ(master.read_16(0x6120), 200);
  EXPECT_EQ(master.read_16(0x6121), 9900);
  EXPECT_EQ(master.read_16(0x6123), 0);
  EXPECT_EQ(master.read_16(0x6124), 200);
  EXPECT_EQ(master.read_16(0x6125), 9900);
  EXPECT_EQ(master.read_16(0x6382), 9900) << "all that the interface can say";
}

TEST(Transducer, TakesASensorOfAnotherRange) {
  Master master;
  const unsigned c = 5;
  const auto write = [&](std::uint16_t index, int value) {
    return master.write_16(object::of_module(index, c), value);
  };
  // 0.5 V at 1 bar to 4.5 V at 11 bar: 250 kPa/V from -25 kPa
  EXPECT_EQ(write(0x6124, 500), 0U);
  EXPECT_EQ(write(0x6125, 4500), 0U);
  EXPECT_EQ(write(0x6120, 1000), 0U);
  EXPECT_EQ(write(0x6121, 11000), 0U);
  EXPECT_NEAR(master.chamber(c).pressure_gain_kPa_per_V, 250.0F, 1e-3F);
  EXPECT_NEAR(master.chamber(c).pressure_offset_kPa, -25.0F, 1e-3F);
  EXPECT_EQ(master.chamber(c).pressure_valid_low_V, 0.5F);
  EXPECT_EQ(master.chamber(c).pressure_valid_high_V, 4.5F);
  EXPECT_EQ(master.read_16(object::of_module(0x6121, c)), 11000);
  EXPECT_EQ(master.read_16(object::of_module(0x6382, c)), 11000);
  EXPECT_EQ(master.chamber(4).pressure_gain_kPa_per_V, 100.0F) << "its neighbour";
}

TEST(Transducer, LeavesTheOtherEndWhereItIs) {
  for (const std::uint16_t moved : Indices{0x6120, 0x6121, 0x6124, 0x6125}) {
    Master master;
    const int was = master.read_16(moved);
    EXPECT_EQ(master.write_16(moved, was + 300), 0U) << moved;
    for (const std::uint16_t other : Indices{0x6120, 0x6121, 0x6124, 0x6125}) {
      const int expected =
          (other <= 0x6121 ? (other == 0x6120 ? 200 : 9900) : (other == 0x6124 ? 200 : 9900)) +
          (other == moved ? 300 : 0);
      EXPECT_EQ(master.read_16(other), expected) << moved << " moved, " << other;
    }
  }
}

TEST(Transducer, RefusesALineThatIsNoneOrFalls) {
  Master master;
  EXPECT_EQ(master.write_16(0x6124, 9900), kRangeAbort) << "a window without width";
  EXPECT_EQ(master.write_16(0x6121, 200), kTooLow) << "every signal one pressure";
  EXPECT_EQ(master.write_16(0x6121, 0), kTooLow) << "falling";
  EXPECT_EQ(master.write_16(0x6123, 1), kTooHigh) << "the line has its own";
  EXPECT_EQ(master.write_16(0x6123, 0), 0U);
  EXPECT_EQ(master.chamber(0).pressure_gain_kPa_per_V, 100.0F);
  EXPECT_EQ(master.chamber(0).pressure_offset_kPa, 0.0F);
  EXPECT_EQ(master.chamber(0).pressure_valid_low_V, 0.2F);
}

TEST(PressureControl, TakesOfWhatItLeavesToTheModelTheOneValueThatChangesNothing) {
  Master master;
  for (const std::uint16_t index : Indices{0x63C0, 0x63C2, 0x63C6, 0x63E0}) {
    EXPECT_EQ(master.read(object::of_module(index, 3), 0) & 0xFFU, 0U) << index;
    EXPECT_EQ(master.write_8(object::of_module(index, 3), 0), 0U) << index;
    EXPECT_EQ(master.write_8(object::of_module(index, 3), 1), kTooHigh) << index;
    EXPECT_EQ(master.write_8(object::of_module(index, 3), -1), kTooLow) << index;
  }
  for (const std::uint16_t index :
       Indices{0x63A3, 0x63A4, 0x63B3, 0x63B6, 0x63C3, 0x63C4, 0x63C5, 0x63E1, 0x63E2}) {
    EXPECT_EQ(master.read_16(index), 0) << index;
    EXPECT_EQ(master.write_16(index, 0), 0U) << index;
    EXPECT_EQ(master.write_16(index, 1), kTooHigh) << index;
  }
  for (const std::uint16_t index : Indices{0x63A2, 0x63C1}) {
    EXPECT_EQ(master.read(index, 0), 0x00010001U) << index;
    EXPECT_EQ(master.write(index, 0, 0x00010001, 4), 0U) << index;
    EXPECT_EQ(master.write(index, 0, 0x00020001, 4), kRangeAbort) << index;
  }
  EXPECT_EQ(master.read_16(0x6391), 10000) << "10 bar are 100 %";
  EXPECT_EQ(master.write_16(0x6391, 5000), kReadOnly);
  EXPECT_EQ(master.settings.take_changed(), 0);
}

TEST(Ramp, IsTheTimeThatTenBarTake) {
  Master master;
  EXPECT_EQ(master.read(0x63B0, 0) & 0xFFU, 1U) << "one time, so short that there is none in practice";
  EXPECT_EQ(master.read_16(0x63B1), 10) << "1000 bar/s";
  const std::uint16_t ramp = object::of_module(0x63B1, 2);
  EXPECT_EQ(master.write_16(ramp, 2000), 0U);
  EXPECT_EQ(master.write_16(object::of_module(0x63B4, 2), 8000), 0U);
  EXPECT_EQ(master.chamber(2).reference_ramp_kPa_per_s, 500.0F);
  EXPECT_EQ(master.chamber(2).reference_fall_kPa_per_s, 125.0F);
  EXPECT_EQ(master.write_8(object::of_module(0x63B0, 2), 2), 0U);
  EXPECT_EQ(master.chamber(2).ramp_type, config::RampType::two_rates);
  EXPECT_EQ(master.read_16(object::of_module(0x63B2, 2)), 2000) << "of a positive value";
  EXPECT_EQ(master.read_16(object::of_module(0x63B5, 2)), 8000);
  EXPECT_EQ(master.write_8(object::of_module(0x63B0, 2), 4), kTooHigh);
  EXPECT_EQ(master.write_16(ramp, 0), kTooLow) << "none is type 0";
  EXPECT_EQ(master.chamber(2).reference_ramp_kPa_per_s, 500.0F);
}

TEST(Ramp, ReadsBackEveryTimeThatWasWritten) {
  Master master;
  for (int time_ms = 1; time_ms <= 65535; time_ms += time_ms < 300 ? 1 : 97) {
    ASSERT_EQ(master.write_16(0x63B1, time_ms), 0U);
    ASSERT_EQ(static_cast<std::uint16_t>(master.read_16(0x63B1)), time_ms);
  }
}

TEST(ControlDeviation, IsWatchedByABandOrByAThresholdToBothSides) {
  Master master;
  EXPECT_EQ(master.read(0x63D1, 0) & 0xFFU, 0U) << "off";
  EXPECT_EQ(master.write_8(0x63D1, 1), 0U);
  EXPECT_EQ(master.write_16(0x63D2, 250), 0U);
  EXPECT_EQ(master.write_16(0x63D4, 300), 0U);
  EXPECT_EQ(master.write_16(0x63D5, -150), 0U);
  EXPECT_TRUE(master.chamber(0).deviation_watched);
  EXPECT_EQ(master.chamber(0).deviation_delay_ms, 250);
  EXPECT_EQ(master.chamber(0).deviation_high_kPa, 30.0F);
  EXPECT_EQ(master.chamber(0).deviation_low_kPa, -15.0F);
  EXPECT_EQ(master.write_16(0x63D3, 200), 0U);
  EXPECT_EQ(master.read_16(0x63D3), 200);
  EXPECT_EQ(master.read_16(0x63D4), 200);
  EXPECT_EQ(master.read_16(0x63D5), -200);
  EXPECT_EQ(master.write_16(0x63D4, -1), kTooLow);
  EXPECT_EQ(master.write_16(0x63D5, 1), kTooHigh);
  EXPECT_EQ(master.write_16(0x63D3, -1), kTooLow);
  EXPECT_EQ(master.write_8(0x63D1, 2), kTooHigh);
}

TEST(TargetWindow, IsSetAsTheDeviationsBandIsAndSaysWhenItHolds) {
  Master master;
  const auto at = [](std::uint16_t index) { return object::of_module(index, 6); };
  EXPECT_EQ(master.write_8(at(0x63F0), 1), 0U);
  EXPECT_EQ(master.write_16(at(0x63F1), 40), 0U);
  EXPECT_EQ(master.write_16(at(0x63F2), 25), 0U);
  EXPECT_EQ(master.write_16(at(0x63F3), 30), 0U);
  EXPECT_TRUE(master.chamber(6).target_watched);
  EXPECT_EQ(master.chamber(6).target_time_ms, 40);
  EXPECT_EQ(master.chamber(6).target_low_kPa, -2.5F);
  EXPECT_EQ(master.chamber(6).target_high_kPa, 3.0F);
  EXPECT_EQ(master.read_16(at(0x63F4)), -25);
  EXPECT_EQ(master.read(at(0x63F5), 0) & 0xFFU, 0U);
  master.image.chamber[6].regulation = regulation::kOnTarget | regulation::kRampRuns;
  EXPECT_EQ(master.read(at(0x63F5), 0) & 0xFFU, 1U);
  EXPECT_EQ(master.read(0x2230, 7) & 0xFFU, 3U);
  EXPECT_EQ(master.read(0x2230, 6) & 0xFFU, 0U);
}

TEST(PressureControl, ChangesItsSettingsInInitOnly) {
  Master master;
  master.image.status_word = 0xB;
  constexpr auto kNotNow = static_cast<std::uint32_t>(Abort::device_state);
  EXPECT_EQ(master.write_16(0x6120, 0), kNotNow);
  EXPECT_EQ(master.write_16(0x63B1, 100), kNotNow);
  EXPECT_EQ(master.write_8(0x63B0, 0), kNotNow);
  EXPECT_EQ(master.write_16(0x63D3, 100), kNotNow);
  EXPECT_EQ(master.write_8(0x63F0, 1), kNotNow);
}

}  // namespace
}  // namespace plenum::canopen
