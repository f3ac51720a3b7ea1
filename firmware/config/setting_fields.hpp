// The fields of the settings: names, and the range of each on its own. Relations between fields: validate().
//
// The bus shows them in this order (2400h.. of the object dictionary): add at the end.
#pragma once

#include <cstdint>

#include "firmware/config/chamber_settings.hpp"

namespace plenum::config {

template <typename Settings, typename Number>
struct SettingField {
  const char* name;  ///< the member's, with its unit
  Number Settings::*member;
  float low;   ///< smallest admissible value
  float high;  ///< largest admissible value
};

inline constexpr SettingField<ChamberSettings, float> kChamberFloats[] = {
    {"pressure_gain_kPa_per_V", &ChamberSettings::pressure_gain_kPa_per_V, 0.1F, 10000.0F},
    {"pressure_offset_kPa", &ChamberSettings::pressure_offset_kPa, -2000.0F, 2000.0F},
    {"pressure_valid_low_V", &ChamberSettings::pressure_valid_low_V, -11.0F, 11.0F},
    {"pressure_valid_high_V", &ChamberSettings::pressure_valid_high_V, -11.0F, 11.0F},
    {"volume_gain_mL_per_V", &ChamberSettings::volume_gain_mL_per_V, -10000.0F, 10000.0F},
    {"volume_offset_mL", &ChamberSettings::volume_offset_mL, -100000.0F, 100000.0F},
    {"position_valid_low_V", &ChamberSettings::position_valid_low_V, -11.0F, 11.0F},
    {"position_valid_high_V", &ChamberSettings::position_valid_high_V, -11.0F, 11.0F},
    {"pressure_low_kPa", &ChamberSettings::pressure_low_kPa, 0.0F, 2000.0F},
    {"pressure_high_kPa", &ChamberSettings::pressure_high_kPa, 0.0F, 2000.0F},
    {"over_pressure_kPa", &ChamberSettings::over_pressure_kPa, 0.0F, 2000.0F},
    {"reference_ramp_kPa_per_s", &ChamberSettings::reference_ramp_kPa_per_s, 0.1F, 1e6F},
    {"command_low_V", &ChamberSettings::command_low_V, 0.0F, 10.0F},
    {"command_high_V", &ChamberSettings::command_high_V, 0.0F, 10.0F},
    {"null_V", &ChamberSettings::null_V, 0.0F, 10.0F},
    {"vent_V", &ChamberSettings::vent_V, 0.0F, 10.0F},
    {"residual_alarm_kPa", &ChamberSettings::residual_alarm_kPa, 0.01F, 2000.0F},
    {"drift_alarm_ratio", &ChamberSettings::drift_alarm_ratio, 0.0F, 1000.0F},
    {"volume_noise_mL", &ChamberSettings::volume_noise_mL, 0.001F, 100.0F},
    {"volume_jerk_mL_per_s3", &ChamberSettings::volume_jerk_mL_per_s3, 1.0F, 1e8F},
    {"reference_fall_kPa_per_s", &ChamberSettings::reference_fall_kPa_per_s, 0.1F, 1e6F},
    {"deviation_low_kPa", &ChamberSettings::deviation_low_kPa, -2000.0F, 0.0F},
    {"deviation_high_kPa", &ChamberSettings::deviation_high_kPa, 0.0F, 2000.0F},
    {"target_low_kPa", &ChamberSettings::target_low_kPa, -2000.0F, 0.0F},
    {"target_high_kPa", &ChamberSettings::target_high_kPa, 0.0F, 2000.0F},
};

inline constexpr SettingField<ChamberSettings, std::uint16_t> kChamberTicks[] = {
    {"residual_ticks", &ChamberSettings::residual_ticks, 0.0F, 60000.0F},
    {"over_pressure_ticks", &ChamberSettings::over_pressure_ticks, 1.0F, 100.0F},
    {"stale_limit_ticks", &ChamberSettings::stale_limit_ticks, 1.0F, 100.0F},
    {"stuck_ticks", &ChamberSettings::stuck_ticks, 0.0F, 60000.0F},
    {"deviation_delay_ms", &ChamberSettings::deviation_delay_ms, 0.0F, 60000.0F},
    {"target_time_ms", &ChamberSettings::target_time_ms, 0.0F, 60000.0F},
};

inline constexpr SettingField<BoardSettings, float> kBoardFloats[] = {
    {"supply_gain_kPa_per_V", &BoardSettings::supply_gain_kPa_per_V, 0.1F, 10000.0F},
    {"supply_offset_kPa", &BoardSettings::supply_offset_kPa, -2000.0F, 2000.0F},
    {"supply_low_kPa", &BoardSettings::supply_low_kPa, 0.0F, 2000.0F},
};

inline constexpr SettingField<BoardSettings, std::uint16_t> kBoardTicks[] = {
    {"supply_ticks", &BoardSettings::supply_ticks, 1.0F, 60000.0F},
    {"setpoint_watchdog_ticks", &BoardSettings::setpoint_watchdog_ticks, 0.0F, 60000.0F},
    {"overrun_limit_ticks", &BoardSettings::overrun_limit_ticks, 1.0F, 1000.0F},
};

}  // namespace plenum::config
