#include "firmware/config/chamber_settings.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

namespace plenum::config {
namespace {

TEST(ChamberSettings, HaveAdmissibleDefaults) {
  EXPECT_TRUE(validate(ChamberSettings{}));
  EXPECT_TRUE(validate(BoardSettings{}));
}

TEST(ChamberSettings, MapZeroToTenVoltsToZeroToOneThousandKilopascals) {
  const ChamberSettings defaults;
  EXPECT_FLOAT_EQ(pressure_kPa(defaults, 0.0F), 0.0F);
  EXPECT_FLOAT_EQ(pressure_kPa(defaults, 10.0F), 1000.0F);
  EXPECT_FLOAT_EQ(volume_mL(defaults, 10.0F), 320.0F);
  EXPECT_FLOAT_EQ(supply_kPa(BoardSettings{}, 7.0F), 700.0F);
}

struct Case {
  const char* field;
  void (*spoil)(ChamberSettings&);
  SettingError error;
};

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

const Case kCases[] = {
    {"pressure_gain_kPa_per_V", [](ChamberSettings& s) { s.pressure_gain_kPa_per_V = 0.0F; },
     SettingError::out_of_range},
    {"pressure_gain_kPa_per_V", [](ChamberSettings& s) { s.pressure_gain_kPa_per_V = kNaN; },
     SettingError::not_finite},
    {"volume_offset_mL", [](ChamberSettings& s) { s.volume_offset_mL = kNaN; }, SettingError::not_finite},
    {"command_high_V", [](ChamberSettings& s) { s.command_high_V = 10.5F; }, SettingError::out_of_range},
    {"stale_limit_ticks", [](ChamberSettings& s) { s.stale_limit_ticks = 0; }, SettingError::out_of_range},
    {"over_pressure_ticks", [](ChamberSettings& s) { s.over_pressure_ticks = 101; },
     SettingError::out_of_range},
    {"safe_output", [](ChamberSettings& s) { s.safe_output = static_cast<SafeOutput>(7); },
     SettingError::out_of_range},
    {"ramp_type", [](ChamberSettings& s) { s.ramp_type = static_cast<RampType>(4); },
     SettingError::out_of_range},
    {"deviation_low_kPa", [](ChamberSettings& s) { s.deviation_low_kPa = 0.1F; }, SettingError::out_of_range},
    {"target_high_kPa", [](ChamberSettings& s) { s.target_high_kPa = -0.1F; }, SettingError::out_of_range},
    {"target_time_ms", [](ChamberSettings& s) { s.target_time_ms = 60001; }, SettingError::out_of_range},
    {"pressure_valid_high_V", [](ChamberSettings& s) { s.pressure_valid_high_V = 0.1F; },
     SettingError::not_admissible},
    {"position_valid_high_V", [](ChamberSettings& s) { s.position_valid_high_V = -1.0F; },
     SettingError::not_admissible},
    {"pressure_high_kPa", [](ChamberSettings& s) { s.pressure_high_kPa = 50.0F; },
     SettingError::not_admissible},
    {"over_pressure_kPa", [](ChamberSettings& s) { s.over_pressure_kPa = 700.0F; },
     SettingError::not_admissible},
    {"over_pressure_kPa", [](ChamberSettings& s) { s.over_pressure_kPa = 995.0F; },
     SettingError::not_admissible},
    {"null_V", [](ChamberSettings& s) { s.null_V = 2.5F; }, SettingError::not_admissible},
    {"null_V", [](ChamberSettings& s) { s.null_V = 7.0F; }, SettingError::not_admissible},
    {"vent_V", [](ChamberSettings& s) { s.vent_V = 5.0F; }, SettingError::not_admissible},
};

TEST(ChamberSettings, AreRefusedByTheFieldToBlameWithTheRangeItMisses) {
  for (const Case& c : kCases) {
    ChamberSettings settings;
    c.spoil(settings);
    const SettingVerdict verdict = validate(settings);
    EXPECT_EQ(verdict.error, c.error) << c.field;
    EXPECT_STREQ(verdict.field, c.field);
    if (c.error != SettingError::not_finite) {
      EXPECT_FALSE(verdict.value >= verdict.low && verdict.value <= verdict.high)
          << c.field << " " << verdict.value;
    }
  }
}

TEST(RampRates, FollowTheType) {
  ChamberSettings settings;
  settings.reference_ramp_kPa_per_s = 300.0F;
  settings.reference_fall_kPa_per_s = 40.0F;
  const auto rates = [&](RampType type) {
    settings.ramp_type = type;
    const RampRates both = ramp_rates(settings);
    return std::pair{both.rise_kPa_s, both.fall_kPa_s};
  };
  EXPECT_EQ(rates(RampType::one_rate), std::pair(300.0F, 300.0F));
  EXPECT_EQ(rates(RampType::two_rates), std::pair(300.0F, 40.0F));
  EXPECT_EQ(rates(RampType::by_quadrant), std::pair(300.0F, 40.0F));
  EXPECT_GE(rates(RampType::none).first * kTick_s, 2000.0F) << "all pressures within a tick";
  EXPECT_GE(rates(RampType::none).second * kTick_s, 2000.0F);
}

TEST(BoardSettings, AreRefusedByTheFieldToBlame) {
  BoardSettings settings;
  settings.supply_gain_kPa_per_V = kNaN;
  EXPECT_STREQ(validate(settings).field, "supply_gain_kPa_per_V");
  settings = {};
  settings.overrun_limit_ticks = 0;
  EXPECT_STREQ(validate(settings).field, "overrun_limit_ticks");
}

}  // namespace
}  // namespace plenum::config
