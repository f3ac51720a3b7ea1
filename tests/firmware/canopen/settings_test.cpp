// Settings over the bus: 2400h.. by their fields, 63A0h and 63A1h as CiA 408 has the limits.
#include <gtest/gtest.h>

#include <string>

#include "firmware/canopen/object_dictionary.hpp"
#include "firmware/config/setting_fields.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

constexpr const char* kNotNow = " 22 00 00 08";
constexpr const char* kBadValue = " 30 00 09 06";
constexpr const char* kTooHigh = " 31 00 09 06";
constexpr const char* kTooLow = " 32 00 09 06";
constexpr const char* kMaxBelowMin = " 36 00 09 06";

constexpr std::uint16_t kInit = 0x8;

/// A bench whose board stands in INIT.
struct InitBench : Bench {
  InitBench() { image.status_word = kInit; }
};

TEST(Settings, AreReadByTheirFields) {
  InitBench bench;
  EXPECT_EQ(bench.answer("605 40 00 24 01 00 00 00 00"), "585 43 00 24 01 00 00 C8 42") << "100 kPa/V";
  bench.settings.set(7, [] {
    config::ChamberSettings settings;
    settings.residual_ticks = 0x1234;
    settings.in_use = false;
    settings.safe_output = config::SafeOutput::vent;
    return settings;
  }());
  EXPECT_EQ(bench.answer("605 40 0F 24 01 00 00 00 00"), "585 4B 0F 24 01 34 12 00 00");
  EXPECT_EQ(bench.answer("605 40 17 24 01 00 00 00 00"), "585 4F 17 24 01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 17 24 02 00 00 00 00"), "585 4F 17 24 02 01 00 00 00");
  EXPECT_EQ(bench.answer("605 40 18 24 01 00 00 00 00"), "585 43 18 24 01 00 00 C8 42") << "supply, kPa/V";
  EXPECT_EQ(bench.answer("605 40 19 24 02 00 00 00 00"), "585 4B 19 24 02 0A 00 00 00") << "watchdog, ticks";
}

TEST(Settings, BearTheNamesAndRangesOfTheirFields) {
  const auto row = [](std::uint16_t index, std::size_t field) {
    return *find(index, static_cast<std::uint8_t>(field + 1)).entry;
  };
  for (std::size_t i = 0; i < std::size(config::kChamberFloats); ++i) {
    EXPECT_STREQ(row(0x2400, i).name, config::kChamberFloats[i].name);
    EXPECT_EQ(row(0x2400, i).range.low, config::kChamberFloats[i].low);
    EXPECT_EQ(row(0x2400, i).range.high, config::kChamberFloats[i].high);
  }
  EXPECT_STREQ(row(0x2408, 2).name, "stale_limit_ticks");
  EXPECT_STREQ(row(0x2418, 2).name, "supply_low_kPa");
  EXPECT_STREQ(row(0x2419, 0).name, "supply_ticks");
}

TEST(Settings, ShowTheSerialNumbersOfWhatIsBuiltIn) {
  InitBench bench;
  bench.settings.set(3, [] {
    config::ChamberSettings settings;
    settings.valve_serial = 0x01020304;
    settings.sensor_serial = 0xA0B0C0D0;
    return settings;
  }());
  EXPECT_EQ(bench.answer("605 40 4B 21 01 00 00 00 00"), "585 43 4B 21 01 04 03 02 01");
  EXPECT_EQ(bench.answer("605 40 4B 21 02 00 00 00 00"), "585 43 4B 21 02 D0 C0 B0 A0");
  EXPECT_EQ(bench.answer("605 40 4C 21 01 00 00 00 00"), "585 43 4C 21 01 00 00 00 00") << "not stated";
  EXPECT_EQ(bench.answer("605 23 4B 21 01 01 00 00 00"), "585 80 4B 21 01 02 00 01 06") << "the installer's";
}

/// A bit has flipped in memory.
template <class T>
void flip_a_bit_of(const T& value) {
  reinterpret_cast<unsigned char&>(const_cast<T&>(value)) ^= 0x10U;
}

TEST(Settings, ThatAreDamagedAreNotSealedByAWriteOfAnotherField) {
  InitBench bench;
  flip_a_bit_of(bench.settings.chamber(3).over_pressure_kPa);
  EXPECT_EQ(bench.answer("605 23 03 24 0A 00 00 16 44"), "585 80 03 24 0A 00 00 06 06");
  EXPECT_EQ(bench.answer("605 2B 0B 24 02 05 00 00 00"), "585 80 0B 24 02 00 00 06 06");
  EXPECT_EQ(bench.answer("605 2F 13 24 01 00 00 00 00"), "585 80 13 24 01 00 00 06 06");
  EXPECT_FALSE(bench.settings.intact(3));
  EXPECT_EQ(bench.settings.chamber(3).pressure_high_kPa, 800.0F);
  EXPECT_EQ(bench.answer("605 23 02 24 0A 00 00 16 44"), "585 60 02 24 0A 00 00 00 00")
      << "another chamber's";

  flip_a_bit_of(bench.settings.board().supply_low_kPa);
  EXPECT_EQ(bench.answer("605 2B 19 24 03 04 00 00 00"), "585 80 19 24 03 00 00 06 06");
  EXPECT_FALSE(bench.settings.intact(config::kChambers));

  bench.send("000 81 05");
  bench.tick(20);
  bench.drain();
  EXPECT_TRUE(bench.settings.intact()) << "a reset of the node brings them back";
  EXPECT_EQ(bench.answer("605 23 03 24 0A 00 00 16 44"), "585 60 03 24 0A 00 00 00 00");
}

TEST(Settings, ThatAreDamagedAreNotStored) {
  InitBench bench;
  flip_a_bit_of(bench.settings.chamber(7).over_pressure_kPa);
  EXPECT_EQ(bench.answer("605 23 10 10 01 73 61 76 65"), "585 80 10 10 01 00 00 06 06");
  EXPECT_EQ(bench.answer("605 23 10 10 03 73 61 76 65"), "585 80 10 10 03 00 00 06 06");
  EXPECT_EQ(bench.node.order().what, StoreOrder::What::none);
  EXPECT_EQ(bench.answer("605 23 10 10 02 73 61 76 65"), "") << "communication parameters are none of them";
  EXPECT_EQ(bench.node.order().what, StoreOrder::What::store);
}

TEST(Settings, AreWrittenOfTheChamberThatTheyName) {
  InitBench bench;
  EXPECT_EQ(bench.answer("605 23 03 24 0A 00 00 16 44"), "585 60 03 24 0A 00 00 00 00") << "600 kPa";
  EXPECT_EQ(bench.settings.chamber(3).pressure_high_kPa, 600.0F);
  EXPECT_EQ(bench.settings.chamber(2).pressure_high_kPa, 800.0F);
  EXPECT_EQ(bench.answer("605 2B 0A 24 02 05 00 00 00"), "585 60 0A 24 02 00 00 00 00");
  EXPECT_EQ(bench.settings.chamber(2).over_pressure_ticks, 5);
  EXPECT_EQ(bench.answer("605 2F 11 24 01 00 00 00 00"), "585 60 11 24 01 00 00 00 00");
  EXPECT_FALSE(bench.settings.chamber(1).in_use);
  EXPECT_EQ(bench.answer("605 2F 11 24 02 01 00 00 00"), "585 60 11 24 02 00 00 00 00");
  EXPECT_EQ(bench.settings.chamber(1).safe_output, config::SafeOutput::vent);
  EXPECT_EQ(bench.answer("605 23 18 24 03 00 00 FA 43"), "585 60 18 24 03 00 00 00 00");
  EXPECT_EQ(bench.settings.board().supply_low_kPa, 500.0F);
  EXPECT_EQ(bench.answer("605 2B 19 24 03 04 00 00 00"), "585 60 19 24 03 00 00 00 00");
  EXPECT_EQ(bench.settings.board().overrun_limit_ticks, 4);
  EXPECT_EQ(bench.settings.take_changed(), 0b1110) << "chambers 1, 2 and 3, counted from 0";
}

TEST(Settings, AreWrittenInInitAndFaultInitOnly) {
  struct Case {
    std::uint16_t status_word;
    bool writable;
  };
  for (const Case& state : {Case{0x8, true}, Case{0x0, true}, Case{0x9, false}, Case{0xB, false},
                            Case{0xF, false}, Case{0x7, false}, Case{0x3, false}, Case{0x1, false}}) {
    Bench bench;
    bench.image.status_word = state.status_word;
    const std::string expected = state.writable ? "585 60" : "585 80";
    for (const std::string object : {"03 24 0A 00 00 16 44", "18 24 03 00 00 FA 43"}) {
      const std::string answer = bench.answer("605 23 " + object);
      EXPECT_EQ(answer.substr(0, 6), expected) << state.status_word;
      if (!state.writable) {
        EXPECT_TRUE(answer.ends_with(kNotNow)) << answer;
      }
    }
    EXPECT_EQ(bench.settings.chamber(3).pressure_high_kPa, state.writable ? 600.0F : 800.0F);
    EXPECT_EQ(bench.settings.board().supply_low_kPa, state.writable ? 500.0F : 0.0F);
  }
}

TEST(Settings, ThatContradictOthersAreRefusedAndTheReasonCanBeRead) {
  InitBench bench;
  // upper limit 950 kPa, beyond the trip of 900 kPa
  EXPECT_EQ(bench.answer("605 23 04 24 0A 00 80 6D 44"), std::string("585 80 04 24 0A") + kBadValue);
  EXPECT_EQ(bench.settings.chamber(4).pressure_high_kPa, 800.0F);
  EXPECT_EQ(bench.settings.take_changed(), 0);
  EXPECT_EQ(bench.answer("605 40 1A 24 01 00 00 00 00"), "585 4F 1A 24 01 05 00 00 00") << "chamber 5 of 8";
  EXPECT_EQ(bench.answer("605 40 1A 24 02 00 00 00 00"), "585 4F 1A 24 02 03 00 00 00") << "not admissible";
  EXPECT_EQ(bench.answer("605 40 1A 24 03 00 00 00 00"), "585 41 1A 24 03 11 00 00 00") << "17 characters";
  EXPECT_EQ(bench.answer("605 60 00 00 00 00 00 00 00"), "585 00 6F 76 65 72 5F 70 72") << "over_pr";
  EXPECT_EQ(bench.answer("605 40 1A 24 04 00 00 00 00"), "585 43 1A 24 04 00 00 61 44") << "900";
  EXPECT_EQ(bench.answer("605 40 1A 24 05 00 00 00 00"), "585 43 1A 24 05 00 80 6D 44") << "950";
  EXPECT_EQ(bench.answer("605 40 1A 24 06 00 00 00 00"), "585 43 1A 24 06 FF 7F 77 44")
      << "100 kPa/V x 9.9 V, the sensor's range: a bit below 990";
}

// Defaults: 0.2..9.9 V, -0.1..10.1 V, 101.325..800 kPa, 3..7 V. 0.1 = 3DCCCCCDh, 10 = 41200000h, -0.2 = BE4CCCCDh, 10.2 = 41233333h,
// 100 = 42C80000h, 801 = 44484000h, 2 = 40000000h, 8 = 41000000h
TEST(Settings, TellAMaximumThatWouldFallBelowItsMinimum) {
  for (const std::string field : {"04 CD CC CC 3D", "03 00 00 20 41", "08 CD CC 4C BE", "07 33 33 23 41",
                                  "0A 00 00 C8 42", "09 00 40 48 44", "0E 00 00 00 40", "0D 00 00 00 41"}) {
    InitBench bench;
    const std::string object = "06 24 " + field.substr(0, 2);
    EXPECT_EQ(bench.answer("605 23 06 24 " + field), "585 80 " + object + kMaxBelowMin);
    EXPECT_EQ(bench.settings.refusal().chamber, 7);
    EXPECT_EQ(bench.settings.refusal().verdict.error, config::SettingError::not_admissible);
    EXPECT_EQ(bench.settings.take_changed(), 0);
  }
  InitBench bench;  // alike is not below: 7 V = 40E00000h
  EXPECT_EQ(bench.answer("605 23 06 24 0D 00 00 E0 40"), std::string("585 80 06 24 0D") + kBadValue);
}

TEST(Settings, OutOfRangeOrNotFiniteAreRefused) {
  InitBench bench;
  EXPECT_EQ(bench.answer("605 23 00 24 01 00 00 C0 7F"), std::string("585 80 00 24 01") + kBadValue) << "NaN";
  EXPECT_EQ(bench.answer("605 23 00 24 01 00 00 00 00"), std::string("585 80 00 24 01") + kTooLow)
      << "gain 0";
  EXPECT_EQ(bench.answer("605 2F 10 24 02 02 00 00 00"), std::string("585 80 10 24 02") + kTooHigh)
      << "safe output 2";
  EXPECT_EQ(bench.answer("605 2B 08 24 02 00 00 00 00"), std::string("585 80 08 24 02") + kTooLow)
      << "0 ticks";
  EXPECT_EQ(bench.settings.take_changed(), 0);
}

TEST(Settings, ShowTheLimitsOfCia408InMillibar) {
  InitBench bench;
  EXPECT_EQ(bench.answer("605 40 A0 63 01 00 00 00 00"), "585 4B A0 63 01 40 1F 00 00") << "8000 mbar";
  EXPECT_EQ(bench.answer("605 40 A1 63 01 00 00 00 00"), "585 4B A1 63 01 F5 03 00 00") << "1013.25 mbar";
  EXPECT_EQ(bench.answer("605 40 A0 63 02 00 00 00 00"), "585 4F A0 63 02 4E 00 00 00");
  EXPECT_EQ(bench.answer("605 40 A1 63 03 00 00 00 00"), "585 4F A1 63 03 FD 00 00 00");
  EXPECT_EQ(bench.answer("605 2B A0 9B 01 88 13 00 00"), "585 60 A0 9B 01 00 00 00 00")
      << "5000 mbar, chamber 8";
  EXPECT_EQ(bench.settings.chamber(7).pressure_high_kPa, 500.0F);
  EXPECT_EQ(bench.answer("605 2B A1 9B 01 89 13 00 00"), std::string("585 80 A1 9B 01") + kMaxBelowMin)
      << "a lower limit above the upper one";
  EXPECT_EQ(bench.answer("605 2B A0 9B 01 21 4E 00 00"), std::string("585 80 A0 9B 01") + kTooHigh)
      << "20001 mbar: the setting ends at 2000 kPa";
  bench.image.status_word = 0x9;
  EXPECT_EQ(bench.answer("605 2B A0 9B 01 58 1B 00 00"), std::string("585 80 A0 9B 01") + kNotNow);
  EXPECT_EQ(bench.settings.chamber(7).pressure_high_kPa, 500.0F);
}

}  // namespace
}  // namespace plenum::canopen
