// What an installer sets for one chamber and for the board: calibration of the sensors, limits, reactions.
//
// Defaults fit an MPYE-type 5/3 proportional valve (0..10 V command, used from 3 V to 7 V, null at 5 V,
// exhaust port open below the null) and 0..10 V sensors: 0..1000 kPa absolute, and a volume of 20..320 mL.
#pragma once

#include <cstdint>

#include "firmware/config/limits.hpp"

namespace plenum::config {

/// What a valve gets while a chamber is not regulated.
enum class SafeOutput : std::uint8_t {
  null,  ///< null_V: both ports shut, the chamber keeps its air but for leaks
  vent   ///< vent_V: the exhaust port is open
};

/// How the reference goes to a set point (63B0h).
enum class RampType : std::uint8_t {
  none,        ///< at once
  one_rate,    ///< at reference_ramp_kPa_per_s up and down
  two_rates,   ///< up at reference_ramp_kPa_per_s, down at reference_fall_kPa_per_s
  by_quadrant  ///< in CiA 408 by the sign of the value, too; an absolute pressure has but one: as two_rates
};

struct ChamberSettings {
  bool in_use = true;  ///< false: nothing is connected; the chamber is not watched and gets null_V

  std::uint32_t valve_serial =
      0;  ///< of the valve built in; 0: not stated. A model of another one is doubted
  std::uint32_t sensor_serial = 0;  ///< of the pressure sensor, likewise

  float pressure_gain_kPa_per_V = 100.0F;  ///< absolute pressure = offset + gain x voltage
  float pressure_offset_kPa = 0.0F;
  float pressure_valid_low_V = 0.2F;   ///< below: wire break (an absolute sensor at ambient gives about 1 V)
  float pressure_valid_high_V = 9.9F;  ///< above: short to supply

  float volume_gain_mL_per_V = 30.0F;  ///< chamber volume = offset + gain x voltage of the position sensor
  float volume_offset_mL = 20.0F;
  float position_valid_low_V = -0.1F;  ///< a sensor with a live zero has its wire-break limit here
  float position_valid_high_V = 10.1F;
  float volume_noise_mL =
      0.05F;  ///< of a tick's measured volume, standard deviation (plenum acceptance measures it)
  /// How hard the load moves the volume: half a stroke of A mL at f Hz has A (2 pi f)^3. Higher values follow faster, and noisier.
  float volume_jerk_mL_per_s3 = 30000.0F;

  float pressure_low_kPa = 101.325F;  ///< lowest reference (63A1h)
  float pressure_high_kPa = 800.0F;   ///< highest reference (63A0h)
  float over_pressure_kPa = 900.0F;   ///< fault 8302h above
  RampType ramp_type = RampType::one_rate;
  float reference_ramp_kPa_per_s = 100000.0F;  ///< steepest reference; the default is no limit in practice
  float reference_fall_kPa_per_s = 100000.0F;  ///< steepest one downwards, where the type has two rates

  float command_low_V = 3.0F;   ///< lowest command the regulator may give
  float command_high_V = 7.0F;  ///< highest command
  float null_V = 5.0F;          ///< both ports shut
  float vent_V = 3.0F;          ///< exhaust port open
  SafeOutput safe_output = SafeOutput::null;

  float residual_alarm_kPa = 60.0F;   ///< fault FF02h when measured minus predicted exceeds this ...
  std::uint16_t residual_ticks = 50;  ///< ... for this many ticks on end; 0: not watched
  /// Warning FF0Bh when the model alone misses, in the mean, this many times its fit error of a tick's pressure [1]; 0: not watched.
  float drift_alarm_ratio = 4.0F;

  bool deviation_watched = false;    ///< warning FF0Ch when set point minus pressure, after the ramp, ...
  float deviation_low_kPa = -50.0F;  ///< ... is below this ...
  float deviation_high_kPa = 50.0F;  ///< ... or above this ...
  std::uint16_t deviation_delay_ms = 500;  ///< ... for so long
  bool target_watched = false;             ///< 63F5h, and 6041h, say when it ...
  float target_low_kPa = -2.0F;            ///< ... is no less than this ...
  float target_high_kPa = 2.0F;            ///< ... and no more than this ...
  std::uint16_t target_time_ms = 100;      ///< ... for so long

  std::uint16_t over_pressure_ticks = 2;  ///< over-pressure must last this long [ticks]
  std::uint16_t stale_limit_ticks = 3;  ///< this many ticks on end without a fresh sample are a fault [ticks]
  std::uint16_t stuck_ticks =
      10;  ///< fault FF0Ah: readings alike while the valve moves [ticks]; 0: not watched
};

struct BoardSettings {
  float supply_gain_kPa_per_V = 100.0F;  ///< absolute supply pressure = offset + gain x voltage
  float supply_offset_kPa = 0.0F;
  float supply_low_kPa = 0.0F;      ///< fault 3412h below; 0: not watched (no sensor fitted)
  std::uint16_t supply_ticks = 20;  ///< the supply must be low this long [ticks]
  std::uint16_t setpoint_watchdog_ticks =
      10;  ///< set points must keep coming while ACTIVE [ticks]; 0: not watched
  std::uint16_t overrun_limit_ticks = 3;  ///< fault FF01h at this many late ticks on end
};

enum class SettingError : std::uint8_t { none, not_finite, out_of_range, not_admissible };

/// Why settings were refused: the field by its member name, its value, and the range that it must lie in.
/// `not_admissible`: the range is what the other settings leave to this one.
struct SettingVerdict {
  SettingError error = SettingError::none;
  const char* field = "";
  float value = 0.0F;
  float low = 0.0F;
  float high = 0.0F;
  bool max_below_min = false;  ///< `not_admissible`: because a highest value has fallen below its lowest
  explicit operator bool() const noexcept { return error == SettingError::none; }
};

SettingVerdict validate(const ChamberSettings& settings) noexcept;
SettingVerdict validate(const BoardSettings& settings) noexcept;

/// Steepest reference upwards and downwards [kPa/s].
struct RampRates {
  float rise_kPa_s, fall_kPa_s;
};
RampRates ramp_rates(const ChamberSettings& settings) noexcept;

/// Absolute pressure [kPa] of a voltage at the pressure sensor [V].
inline float pressure_kPa(const ChamberSettings& settings, float sensor_V) noexcept {
  return settings.pressure_offset_kPa + settings.pressure_gain_kPa_per_V * sensor_V;
}

/// Chamber volume [mL] of a voltage at the position sensor [V].
inline float volume_mL(const ChamberSettings& settings, float sensor_V) noexcept {
  return settings.volume_offset_mL + settings.volume_gain_mL_per_V * sensor_V;
}

/// What the jerk of the load adds to a volume in a tick, in units of its sensor's noise [1] (control/volume_observer.hpp).
inline float tracking_index(const ChamberSettings& settings) noexcept {
  return settings.volume_jerk_mL_per_s3 * kTick_s * kTick_s * kTick_s / settings.volume_noise_mL;
}

/// Absolute supply pressure [kPa] of a voltage at the supply sensor [V].
inline float supply_kPa(const BoardSettings& settings, float sensor_V) noexcept {
  return settings.supply_offset_kPa + settings.supply_gain_kPa_per_V * sensor_V;
}

}  // namespace plenum::config
