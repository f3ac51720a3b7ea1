#include "host-sim/rig/standard_rigs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "firmware/config/setting_fields.hpp"

namespace plenum::host::rig {
namespace {

using plenum::config::kChambers;

constexpr double kPa = 1e3;
constexpr double kMl = 1e-6;

/// A volume that swings slowly and, a third as far, faster: never twice the same within a minute.
plant::VolumeMotion motion(double mean_m3, double swing, double frequency_Hz, double phase_rad) {
  const std::array<plant::VolumeSine, plant::VolumeMotion::kSines> sines = {{
      {.amplitude_m3 = 0.75 * swing * mean_m3, .frequency_Hz = frequency_Hz, .phase_rad = phase_rad},
      {.amplitude_m3 = 0.25 * swing * mean_m3,
       .frequency_Hz = 1.618 * frequency_Hz,
       .phase_rad = 2.0 * phase_rad + 1.0},
      {},
  }};
  return plant::VolumeMotion(mean_m3, sines);
}

/// Ten volts of the position sensor are twice the largest chamber volume; the installer's calibration is
/// true.
void fit_volume_sensor(ChamberConfig& chamber, plenum::config::ChamberSettings& settings) {
  const double largest_m3 = 2.0 * chamber.volume.mean_m3();
  chamber.volume_m3 = {.at_zero_V = 0.0, .per_V = largest_m3 / 10.0};
  settings.volume_offset_mL = 0.0F;
  settings.volume_gain_mL_per_V = static_cast<float>(largest_m3 / 10.0 / kMl);
}

/// At which an over-pressure is told: 1.3 times the supply, as far as a board's settings go.
double over_pressure_Pa(double supply_Pa) {
  return std::min(1.3 * supply_Pa, 2e6);
}

/// Of 1 bar a volt, 2 bar, ...: the first sensor whose valid range holds the over-pressure of this supply.
SensorConfig pressure_sensor(double supply_Pa) {
  constexpr double kBar = 1e5, kValid_V = 9.9;
  return {.at_zero_V = 0.0, .per_V = kBar * std::ceil(over_pressure_Pa(supply_Pa) / (kValid_V * kBar))};
}

/// A pressure sensor for this supply, the limits that go with it, and a calibration that is true.
void fit_pressures(ChamberConfig& chamber, plenum::config::ChamberSettings& settings, double supply_Pa,
                   double ambient_Pa) {
  chamber.pressure_Pa = pressure_sensor(supply_Pa);
  settings.pressure_gain_kPa_per_V = static_cast<float>(chamber.pressure_Pa.per_V / kPa);
  settings.pressure_low_kPa = static_cast<float>(ambient_Pa / kPa);
  settings.pressure_high_kPa = static_cast<float>(std::min(supply_Pa, 1.9e6) / kPa);
  settings.over_pressure_kPa = static_cast<float>(over_pressure_Pa(supply_Pa) / kPa);
}

void fit_supply_sensor(BoardConfig& board, double supply_Pa) {
  board.supply_Pa = pressure_sensor(supply_Pa);
  board.settings.board.supply_gain_kPa_per_V = static_cast<float>(board.supply_Pa.per_V / kPa);
}

/// As near to `value` as a board takes it.
float admissible(float plenum::config::ChamberSettings::*setting, double value) {
  const auto* const field =
      std::ranges::find(plenum::config::kChamberFloats, setting,
                        &plenum::config::SettingField<plenum::config::ChamberSettings, float>::member);
  return std::clamp(static_cast<float>(value), field->low, field->high);
}

/// What the converter leaves of its noise after averaging, in millilitres of each sensor; no less than the rounding of its step.
void fit_noise(plenum::Settings& settings, const BoardConfig& board) {
  const double step_V = std::ldexp(board.adc.high_V - board.adc.low_V, -board.adc.bits);
  const double mean_noise_V =
      std::max(board.adc.sample_noise_V / std::sqrt(board.adc.samples_per_tick), step_V / std::sqrt(12.0));
  for (auto& chamber : settings.chamber) {
    chamber.volume_noise_mL = admissible(&plenum::config::ChamberSettings::volume_noise_mL,
                                         mean_noise_V * static_cast<double>(chamber.volume_gain_mL_per_V));
  }
}

void require_chambers(unsigned chambers) {
  if (chambers < 1 || chambers > kChambers) {
    throw std::invalid_argument("a board has 1 to " + std::to_string(kChambers) + " chambers, not " +
                                std::to_string(chambers));
  }
}

}  // namespace

RigConfig mpye_rig(const MpyeRig& wanted) {
  require_chambers(wanted.chambers);
  RigConfig rig{.board = {}, .bus = {}, .seed = wanted.seed};
  plant::Random random(wanted.seed ^ 0x6d70'7965U);
  for (unsigned b = 0; b < wanted.boards; ++b) {
    BoardConfig board;
    board.settings.node.node_id = static_cast<std::uint8_t>(b + 1);
    board.settings.node.identity.serial = b + 1;
    for (unsigned c = 0; c < wanted.chambers; ++c) {
      const double mean_m3 = 0.4e-3 + 0.1e-3 * c;
      const double frequency_Hz = 0.2 + 0.4 * random.uniform();
      const double phase_rad = 2.0 * std::numbers::pi * random.uniform();
      const auto channel = c % 2 == 0 ? plant::MpyeChannel::a : plant::MpyeChannel::b_mirrored;
      plant::ChamberConfig chamber{
          .gas = plant::reference_atmosphere(), .supply_Pa = wanted.supply_Pa, .spool = {}};
      chamber.ambient_Pa = wanted.ambient_Pa;
      chamber.initial_pressure_Pa = chamber.ambient_Pa;
      if (wanted.spool)
        chamber.spool = plant::SpoolConfig{.natural_frequency_Hz = 65.0, .damping_ratio = 0.7};
      board.chamber.push_back({.valve = plant::MpyeValve(channel),
                               .chamber = chamber,
                               .volume = motion(mean_m3, wanted.volume_swing, frequency_Hz, phase_rad),
                               .volume_m3 = {}});
      plenum::config::ChamberSettings& settings = board.settings.chamber[c];
      fit_volume_sensor(board.chamber.back(), settings);
      fit_pressures(board.chamber.back(), settings, chamber.supply_Pa, chamber.ambient_Pa);
      const double omega = 2.0 * std::numbers::pi * 1.618 * frequency_Hz;
      settings.volume_jerk_mL_per_s3 = admissible(&plenum::config::ChamberSettings::volume_jerk_mL_per_s3,
                                                  wanted.volume_swing * mean_m3 / kMl * std::pow(omega, 3));
    }
    fit_supply_sensor(board, wanted.supply_Pa);
    fit_noise(board.settings, board);
    rig.board.push_back(std::move(board));
  }
  return rig;
}

RigConfig thin_plate_rig(const trace::RigDescription& description, const ThinPlateRig& wanted) {
  require_chambers(wanted.chambers);
  std::optional<effects::ChamberEffects> effects;
  if (!description.effects.empty()) effects = effects::chamber_effects(description.effects);
  RigConfig rig{.board = {}, .bus = {}, .seed = wanted.seed};
  plant::Random random(wanted.seed ^ 0x7468'696eU);
  plant::Gas gas;
  gas.temperature_K = description.gas.temperature_K;
  const trace::RigDescription::Valve& sheet = description.valve;
  const plant::ThinPlateValve valve({.open_above_V = sheet.open_above_V,
                                     .exhaust_below_V = sheet.exhaust_below_V,
                                     .inlet_area_per_V_m2 = sheet.inlet_area_per_V_m2,
                                     .exhaust_area_per_V_m2 = sheet.exhaust_area_per_V_m2,
                                     .inlet_leak_m2 = sheet.inlet_leak_m2,
                                     .exhaust_leak_m2 = sheet.exhaust_leak_m2,
                                     .transition_m2 = sheet.transition_m2,
                                     .discharge_coefficient = sheet.discharge_coefficient},
                                    gas);
  for (unsigned b = 0; b < wanted.boards; ++b) {
    BoardConfig board;
    board.settings.node.node_id = static_cast<std::uint8_t>(b + 1);
    board.settings.node.identity.serial = b + 1;
    for (unsigned c = 0; c < wanted.chambers; ++c) {
      const double phase_rad = 2.0 * std::numbers::pi * random.uniform();
      const double frequency_Hz = 0.3 + 0.7 * random.uniform();
      plant::ChamberConfig chamber{.gas = gas, .supply_Pa = description.supply.pressure_Pa, .spool = {}};
      chamber.ambient_Pa = description.ambient.pressure_Pa;
      chamber.initial_pressure_Pa = chamber.ambient_Pa;
      board.chamber.push_back(
          {.valve = valve,
           .chamber = chamber,
           .volume = motion(wanted.volume_m3 * (1.0 + 0.1 * c), wanted.volume_swing, frequency_Hz, phase_rad),
           .volume_m3 = {},
           .effects = effects});
      plenum::config::ChamberSettings& settings = board.settings.chamber[c];
      fit_volume_sensor(board.chamber.back(), settings);
      fit_pressures(board.chamber.back(), settings, chamber.supply_Pa, chamber.ambient_Pa);
    }
    // The description's noise is that of a row, after averaging.
    board.adc.sample_noise_V = description.sensor.pressure_noise_Pa /
                               board.chamber.front().pressure_Pa.per_V *
                               std::sqrt(board.adc.samples_per_tick);
    fit_supply_sensor(board, description.supply.pressure_Pa);
    fit_noise(board.settings, board);
    rig.board.push_back(std::move(board));
  }
  return rig;
}

}  // namespace plenum::host::rig
