// Objects 2400h..241Ah (own): the settings of chambers and board, field by field.
//
// A record follows a table of config/setting_fields.hpp: sub-index k is its k-th field, by its name and range. Settings are changed
// in INIT and FAULT_INIT only; in the latter because a sensor's window that is set wrong makes a fault which no reset could clear.
#pragma once

#include "firmware/canopen/dictionary/rows.hpp"
#include "firmware/config/setting_fields.hpp"

namespace plenum::canopen::dictionary {

/// 241Ah tells more.
inline Abort abort_of(const config::SettingVerdict& verdict) noexcept {
  if (verdict.max_below_min) return Abort::max_below_min;
  switch (verdict.error) {
    case config::SettingError::none:
      return Abort::none;
    case config::SettingError::out_of_range:
      return verdict.value > verdict.high ? Abort::value_too_high : Abort::value_too_low;
    case config::SettingError::not_finite:
    case config::SettingError::not_admissible:
      return Abort::value_range;
  }
  return Abort::general;
}

// ---- of a chamber ----

inline Abort set_chamber(Device& device, Place at, const config::ChamberSettings& settings) noexcept {
  const bool must_vent = (std::uint32_t{device.image.must_vent} >> at.instance & 1U) != 0;
  const bool refused =
      must_vent && !device.settings.restoring();  // a reset brings back what a power cycle would
  if (refused || (device.image.status_word & word::kStateMask) != 0) return Abort::device_state;
  if (!device.settings.may_edit(at.instance)) return Abort::hardware_error;
  return abort_of(device.settings.set(at.instance, settings));
}

inline Abort read_chamber_float(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = bits_of(device.settings.chamber(at.instance).*config::kChamberFloats[at.sub - 1U].member);
  return Abort::none;
}

inline Abort write_chamber_float(Device& device, Place at, std::uint32_t bits) noexcept {
  config::ChamberSettings settings = device.settings.edited(at.instance);
  settings.*config::kChamberFloats[at.sub - 1U].member = std::bit_cast<float>(bits);
  return set_chamber(device, at, settings);
}

inline Abort read_chamber_ticks(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = device.settings.chamber(at.instance).*config::kChamberTicks[at.sub - 1U].member;
  return Abort::none;
}

inline Abort write_chamber_ticks(Device& device, Place at, std::uint32_t bits) noexcept {
  config::ChamberSettings settings = device.settings.edited(at.instance);
  settings.*config::kChamberTicks[at.sub - 1U].member = static_cast<std::uint16_t>(bits);
  return set_chamber(device, at, settings);
}

template <auto member>
Abort read_setting(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(device.settings.chamber(at.instance).*member);
  return Abort::none;
}

template <auto member>
Abort write_setting(Device& device, Place at, std::uint32_t bits) noexcept {
  config::ChamberSettings settings = device.settings.edited(at.instance);
  settings.*member = static_cast<std::remove_reference_t<decltype(settings.*member)>>(bits);
  return set_chamber(device, at, settings);
}

// ---- of the board ----

inline Abort set_board(Device& device, const config::BoardSettings& settings) noexcept {
  if ((device.image.status_word & word::kStateMask) != 0) return Abort::device_state;
  if (!device.settings.may_edit(config::kChambers)) return Abort::hardware_error;
  return abort_of(device.settings.set(settings));
}

inline Abort read_board_float(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = bits_of(device.settings.board().*config::kBoardFloats[at.sub - 1U].member);
  return Abort::none;
}

inline Abort write_board_float(Device& device, Place at, std::uint32_t bits) noexcept {
  config::BoardSettings settings = device.settings.edited_board();
  settings.*config::kBoardFloats[at.sub - 1U].member = std::bit_cast<float>(bits);
  return set_board(device, settings);
}

inline Abort read_board_ticks(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = device.settings.board().*config::kBoardTicks[at.sub - 1U].member;
  return Abort::none;
}

inline Abort write_board_ticks(Device& device, Place at, std::uint32_t bits) noexcept {
  config::BoardSettings settings = device.settings.edited_board();
  settings.*config::kBoardTicks[at.sub - 1U].member = static_cast<std::uint16_t>(bits);
  return set_board(device, settings);
}

// ---- why a setting was refused ----

inline Abort read_refusal(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const config::SettingRefusal& refusal = device.settings.refusal();
  switch (at.sub) {
    case 1:
      bits = refusal.chamber;
      break;
    case 2:
      bits = static_cast<std::uint32_t>(refusal.verdict.error);
      break;
    case 4:
      bits = bits_of(refusal.verdict.value);
      break;
    case 5:
      bits = bits_of(refusal.verdict.low);
      break;
    default:
      bits = bits_of(refusal.verdict.high);
      break;
  }
  return Abort::none;
}

inline std::span<const std::uint8_t> read_refused_field(const Device& device, Place) noexcept {
  return text_bytes(device.settings.refusal().verdict.field);
}

// ---- rows ----

/// A record of one row a field.
template <std::size_t fields>
struct FieldRows {
  Entry row[fields + 1];
};

template <typename Field, std::size_t fields>
constexpr FieldRows<fields> field_rows(std::uint16_t index, Many many, const char* name,
                                       const Field (&field)[fields], DataType type, ReadValue read,
                                       WriteValue write) {
  FieldRows<fields> rows{};
  rows.row[0] = highest<fields>(index, many, name);
  for (std::size_t i = 0; i < fields; ++i) {
    rows.row[i + 1] = kept(value(index, static_cast<int>(i + 1), many, field[i].name, type, read_write, no,
                                 {field[i].low, field[i].high, true}, read, write));
  }
  return rows;
}

inline constexpr auto kChamberFloatRows =
    field_rows(object::kChamberSettings, kChambersNext, "Chamber settings", config::kChamberFloats, real32,
               read_chamber_float, write_chamber_float);
inline constexpr auto kChamberTickRows =
    field_rows(object::kChamberTicks, kChambersNext, "Chamber settings: ticks and times",
               config::kChamberTicks, unsigned16, read_chamber_ticks, write_chamber_ticks);
/// One of 0 to `most`.
template <auto member>
constexpr Entry choice(int sub, const char* name, float most) {
  return kept(value(object::kChamberChoices, sub, kChambersNext, name, unsigned8, read_write, no,
                    {0.0F, most, true}, read_setting<member>, write_setting<member>));
}

inline constexpr Entry kChamberChoiceRows[] = {
    highest<5>(object::kChamberChoices, kChambersNext, "Chamber settings: choices"),
    choice<&config::ChamberSettings::in_use>(1, "in_use", 1.0F),
    choice<&config::ChamberSettings::safe_output>(2, "safe_output (0 null, 1 vent)", 1.0F),
    choice<&config::ChamberSettings::ramp_type>(
        3, "ramp_type (0 none, 1 one rate, 2 two rates, 3 by quadrant: as 2)", 3.0F),
    choice<&config::ChamberSettings::deviation_watched>(4, "deviation_watched", 1.0F),
    choice<&config::ChamberSettings::target_watched>(5, "target_watched", 1.0F),
};
inline constexpr auto kBoardFloatRows =
    field_rows(object::kBoardSettings, kOnce, "Board settings", config::kBoardFloats, real32,
               read_board_float, write_board_float);
inline constexpr auto kBoardTickRows =
    field_rows(object::kBoardTicks, kOnce, "Board settings: ticks", config::kBoardTicks, unsigned16,
               read_board_ticks, write_board_ticks);
inline constexpr Entry kRefusalRows[] = {
    highest<6>(object::kSettingRefusal, kOnce, "Last setting refused"),
    value(object::kSettingRefusal, 1, kOnce, "Chamber from 1, 0: the board", unsigned8, read_only, no, kAny,
          read_refusal),
    value(object::kSettingRefusal, 2, kOnce,
          "Reason (0 none, 1 not finite, 2 out of range, 3 contradicts others)", unsigned8, read_only, no,
          kAny, read_refusal),
    at_sub(3, bytes(object::kSettingRefusal, kOnce, "Field", visible_string, read_only, read_refused_field)),
    value(object::kSettingRefusal, 4, kOnce, "Refused value", real32, read_only, no, kAny, read_refusal),
    value(object::kSettingRefusal, 5, kOnce, "Low limit left by the others", real32, read_only, no, kAny,
          read_refusal),
    value(object::kSettingRefusal, 6, kOnce, "High limit left by the others", real32, read_only, no, kAny,
          read_refusal),
};

}  // namespace plenum::canopen::dictionary
