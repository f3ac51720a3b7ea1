// Objects 6040h..9FFFh: device control and pressure control (CiA 408). Pressures are absolute, in mbar.
#pragma once

#include "firmware/canopen/dictionary/process.hpp"
#include "firmware/canopen/dictionary/settings.hpp"

namespace plenum::canopen::dictionary {

constexpr float kMbar_per_kPa = 10.0F;

template <config::Pascals ChamberImage::*member>
Abort read_chamber_mbar(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = mbar_bits((device.image.chamber[at.instance].*member).in_core() * numeric::Scalar(kMbar_per_kPa));
  return Abort::none;
}

template <Setpoint ChamberImage::*member>
Abort read_setpoint_mbar(const Device& device, Place at, std::uint32_t& bits) noexcept {
  constexpr auto kMbar_per_Pa =
      numeric::Scalar(1.0 / kPascal_per_mbar);  // leaves every tie of whole half mbar where it is
  bits = mbar_bits(device.image.chamber[at.instance].*member * kMbar_per_Pa);
  return Abort::none;
}

template <Setpoint ChamberImage::*member>
Abort write_setpoint_mbar(Device& device, Place at, std::uint32_t bits) noexcept {
  set_setpoint<member>(device, at, numeric::Scalar(kPascal_per_mbar * static_cast<std::int16_t>(bits)));
  return Abort::none;
}

inline Abort read_deviation_mbar(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const ChamberImage& chamber = device.image.chamber[at.instance];
  const numeric::Scalar deviation_kPa = chamber.reference_Pa.in_core() - chamber.actual_Pa.in_core();
  bits = mbar_bits(deviation_kPa * numeric::Scalar(kMbar_per_kPa));
  return Abort::none;
}

template <float config::ChamberSettings::*member>
Abort read_limit_mbar(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = mbar_bits(device.settings.chamber(at.instance).*member * kMbar_per_kPa);
  return Abort::none;
}

template <float config::ChamberSettings::*member>
Abort write_limit_mbar(Device& device, Place at, std::uint32_t bits) noexcept {
  config::ChamberSettings settings = device.settings.edited(at.instance);
  settings.*member = static_cast<float>(static_cast<std::int16_t>(bits)) / kMbar_per_kPa;
  return set_chamber(device, at, settings);
}

inline Abort read_error_code(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = error_state(device.image).code;
  return Abort::none;
}

inline Abort write_control_word(Device& device, Place, std::uint32_t bits) noexcept {
  // between two ticks R may rise and fall again, or fall and rise
  if ((bits & word::kResetFault) != 0 && (device.image.control_word & word::kResetFault) == 0)
    device.image.reset_word = static_cast<std::uint16_t>(bits);
  device.image.control_word = static_cast<std::uint16_t>(bits);
  return Abort::none;
}

inline Abort read_control_mode(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(device.image.control_mode.value());
  return Abort::none;
}

/// While ACTIVE the mode stands: a change would be a step of the command that nobody asked for.
inline Abort write_control_mode(Device& device, Place, std::uint32_t bits) noexcept {
  const auto mode = static_cast<ControlMode>(static_cast<std::int8_t>(bits));
  switch (mode) {
    case ControlMode::excitation:
    case ControlMode::pressure_open_loop:
    case ControlMode::pressure_closed_loop:
      if (mode != device.image.control_mode && (device.image.status_word & word::kStateMask) == word::kActive)
        return Abort::device_state;
      device.image.control_mode = mode;
      return Abort::none;
  }
  return Abort::value_range;
}

inline Abort accept_device_mode(Device&, Place, std::uint32_t) noexcept {
  return Abort::none;
}  // its range allows only 1

constexpr std::uint32_t kUnitBar = 0x4E;
constexpr std::uint32_t kPrefixMilli = 0xFD;

using Limits = config::ChamberSettings;

/// That of the setting.
consteval Range limit_range_mbar(float config::ChamberSettings::*member) {
  for (const auto& field : config::kChamberFloats) {
    if (field.member == member) return {field.low * kMbar_per_kPa, field.high * kMbar_per_kPa, true};
  }
  return kAny;
}

inline constexpr Entry kFluidPowerRows[] = {
    value(0x6040, 0, kOnce, "Control word", unsigned16, read_write, receive_and_transmit, kAny,
          read_image<&ProcessImage::control_word>, write_control_word),
    value(0x6041, 0, kOnce, "Status word", unsigned16, read_only, transmit, kAny,
          read_image<&ProcessImage::status_word>),
    value(0x6042, 0, kOnce, "Device mode", integer8, read_write, no, {1.0F, 1.0F, true}, fixed<1>,
          accept_device_mode),
    value(0x6043, 0, kOnce, "Control mode", integer8, read_write, no, {-1.0F, 4.0F, true}, read_control_mode,
          write_control_mode),
    value(0x604E, 0, kOnce, "Error code", unsigned16, read_only, transmit, kAny, read_error_code),
    value(0x604F, 0, kOnce, "Local (0: the bus has control)", integer8, constant, no, kAny, fixed<0>),

    bytes(0x6054, kOnce, "Device model description", visible_string, constant,
          read_string<&Identity::device_name>),
    bytes(0x6057, kOnce, "Device vendor name", visible_string, constant, read_string<&Identity::vendor_name>),

    // CiA 408: pressure control, per chamber; pressures are absolute, in mbar
    highest<3>(0x6380, kChambersApart, "Set point"),
    value(0x6380, 1, kChambersApart, "Set point", integer16, read_write, receive_and_transmit,
          kSetpointRange_mbar, read_setpoint_mbar<&C::setpoint_Pa>, write_setpoint_mbar<&C::setpoint_Pa>),
    value(0x6380, 2, kChambersApart, "Set point unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6380, 3, kChambersApart, "Set point prefix", integer8, constant, no, kAny, fixed<kPrefixMilli>),
    highest<3>(0x6381, kChambersApart, "Actual value"),
    value(0x6381, 1, kChambersApart, "Actual value", integer16, read_only, transmit, kAny,
          read_chamber_mbar<&C::actual_Pa>),
    value(0x6381, 2, kChambersApart, "Actual value unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6381, 3, kChambersApart, "Actual value prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
    highest<3>(0x6390, kChambersApart, "Demand value"),
    value(0x6390, 1, kChambersApart, "Demand value", integer16, read_only, transmit, kAny,
          read_chamber_mbar<&C::demand_Pa>),
    value(0x6390, 2, kChambersApart, "Demand value unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6390, 3, kChambersApart, "Demand value prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
    highest<3>(0x6391, kChambersApart, "Reference value"),
    value(0x6391, 1, kChambersApart, "Reference value", integer16, read_only, transmit, kAny,
          read_chamber_mbar<&C::reference_Pa>),
    value(0x6391, 2, kChambersApart, "Reference value unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6391, 3, kChambersApart, "Reference value prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
    highest<3>(0x6394, kChambersApart, "Hold set point"),
    kept(value(0x6394, 1, kChambersApart, "Hold set point", integer16, read_write, receive_and_transmit,
               kSetpointRange_mbar, read_setpoint_mbar<&C::hold_setpoint_Pa>,
               write_setpoint_mbar<&C::hold_setpoint_Pa>)),
    value(0x6394, 2, kChambersApart, "Hold set point unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6394, 3, kChambersApart, "Hold set point prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
    highest<3>(0x63A0, kChambersApart, "Upper limit"),
    value(0x63A0, 1, kChambersApart, "Upper limit", integer16, read_write, no,
          limit_range_mbar(&Limits::pressure_high_kPa), read_limit_mbar<&Limits::pressure_high_kPa>,
          write_limit_mbar<&Limits::pressure_high_kPa>),
    value(0x63A0, 2, kChambersApart, "Upper limit unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x63A0, 3, kChambersApart, "Upper limit prefix", integer8, constant, no, kAny, fixed<kPrefixMilli>),
    highest<3>(0x63A1, kChambersApart, "Lower limit"),
    value(0x63A1, 1, kChambersApart, "Lower limit", integer16, read_write, no,
          limit_range_mbar(&Limits::pressure_low_kPa), read_limit_mbar<&Limits::pressure_low_kPa>,
          write_limit_mbar<&Limits::pressure_low_kPa>),
    value(0x63A1, 2, kChambersApart, "Lower limit unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x63A1, 3, kChambersApart, "Lower limit prefix", integer8, constant, no, kAny, fixed<kPrefixMilli>),
    highest<3>(0x63D0, kChambersApart, "Control deviation"),
    value(0x63D0, 1, kChambersApart, "Control deviation", integer16, read_only, transmit, kAny,
          read_deviation_mbar),
    value(0x63D0, 2, kChambersApart, "Control deviation unit", unsigned8, constant, no, kAny,
          fixed<kUnitBar>),
    value(0x63D0, 3, kChambersApart, "Control deviation prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
    value(0x67FF, 0, kChambersApart, "Device type of the module", unsigned32, constant, no, kAny,
          fixed<kModuleType>),
};

}  // namespace plenum::canopen::dictionary
