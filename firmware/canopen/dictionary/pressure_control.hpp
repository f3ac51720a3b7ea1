// Objects 6120h..67FFh: transducer and pressure control of each chamber (CiA 408). Pressures are absolute, in mbar.
#pragma once

#include "firmware/canopen/dictionary/process.hpp"
#include "firmware/canopen/dictionary/settings.hpp"

namespace plenum::canopen::dictionary {

using Limits = config::ChamberSettings;

// ---- quantities: {value, SI unit, prefix} ----

constexpr std::uint32_t kUnitSecond = 0x03;
constexpr std::uint32_t kUnitHertz = 0x20;
constexpr std::uint32_t kUnitVolt = 0x26;
constexpr std::uint32_t kUnitBar = 0x4E;
constexpr std::uint32_t kPrefixNone = 0x00;
constexpr std::uint32_t kPrefixMilli = 0xFD;

/// `row` is its value, of sub-index 1.
template <std::uint32_t unit, std::uint32_t prefix>
constexpr std::array<Entry, 4> quantity(const char* name, Entry row) {
  return {highest<3>(row.index, kChambersApart, name), row,
          value(row.index, 2, kChambersApart, "Unit", unsigned8, constant, no, kAny, fixed<unit>),
          value(row.index, 3, kChambersApart, "Prefix", integer8, constant, no, kAny, fixed<prefix>)};
}

/// Read only.
constexpr std::array<Entry, 4> in_mbar(std::uint16_t index, const char* name, Mappable mappable,
                                       ReadValue read) {
  return quantity<kUnitBar, kPrefixMilli>(
      name, value(index, 1, kChambersApart, name, integer16, read_only, mappable, kAny, read));
}

/// Of a setting.
template <std::uint32_t unit = kUnitBar>
constexpr std::array<Entry, 4> setting_in_milli(std::uint16_t index, const char* name, DataType type,
                                                Range range, ReadValue read, WriteValue write) {
  return quantity<unit, kPrefixMilli>(
      name, value(index, 1, kChambersApart, name, type, read_write, no, range, read, write));
}

// ---- what is not to be changed: the one value that leaves everything as it is ----

constexpr Range kZeroOnly{0.0F, 0.0F, true};
constexpr std::uint32_t kFactorOne = 0x0001'0001;  // numerator << 16 | denominator

constexpr Entry off_only(std::uint16_t index, const char* name) {
  return value(index, 0, kChambersApart, name, integer8, read_write, no, kZeroOnly, fixed<0>, accept);
}

template <std::uint32_t unit = kUnitBar, std::uint32_t prefix = kPrefixMilli>
constexpr std::array<Entry, 4> zero_only(std::uint16_t index, const char* name, DataType type = integer16) {
  return quantity<unit, prefix>(
      name, value(index, 1, kChambersApart, name, type, read_write, no, kZeroOnly, fixed<0>, accept));
}

inline Abort accept_one(Device&, Place, std::uint32_t bits) noexcept {
  return bits == kFactorOne ? Abort::none : Abort::value_range;
}

constexpr Entry one_only(std::uint16_t index, const char* name) {
  return value(index, 0, kChambersApart, name, unsigned32, read_write, no, kAny, fixed<kFactorOne>,
               accept_one);
}

// ---- the image ----

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

template <Setpoint ChamberImage::*member>
constexpr std::array<Entry, 4> setpoint_mbar(std::uint16_t index, const char* name, Kept stored) {
  Entry row = value(index, 1, kChambersApart, name, integer16, read_write, receive_and_transmit,
                    kSetpointRange_mbar, read_setpoint_mbar<member>, write_setpoint_mbar<member>);
  row.kept = stored;
  return quantity<kUnitBar, kPrefixMilli>(name, row);
}

inline Abort read_on_target(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = device.image.chamber[at.instance].regulation & regulation::kOnTarget;
  return Abort::none;
}

// ---- the settings, in mbar and ms ----

template <float Limits::*member>
Abort read_limit_mbar(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = mbar_bits(device.settings.chamber(at.instance).*member * kMbar_per_kPa);
  return Abort::none;
}

inline float kPa_of(std::uint32_t mbar_bits) noexcept {
  return static_cast<float>(static_cast<std::int16_t>(mbar_bits)) / kMbar_per_kPa;
}

template <float Limits::*member>
Abort write_limit_mbar(Device& device, Place at, std::uint32_t bits) noexcept {
  Limits settings = device.settings.edited(at.instance);
  settings.*member = kPa_of(bits);
  return set_chamber(device, at, settings);
}

/// That of the setting.
constexpr Range limit_range_mbar(float Limits::*member) {
  for (const auto& field : config::kChamberFloats) {
    if (field.member == member) return {field.low * kMbar_per_kPa, field.high * kMbar_per_kPa, true};
  }
  return kAny;
}

template <float Limits::*member>
constexpr std::array<Entry, 4> limit_mbar(std::uint16_t index, const char* name) {
  return setting_in_milli(index, name, integer16, limit_range_mbar(member), read_limit_mbar<member>,
                          write_limit_mbar<member>);
}

/// A band of one width to both sides: what is read is its upper half.
template <float Limits::*low, float Limits::*high>
Abort write_threshold_mbar(Device& device, Place at, std::uint32_t bits) noexcept {
  Limits settings = device.settings.edited(at.instance);
  settings.*high = kPa_of(bits);
  settings.*low = -kPa_of(bits);
  return set_chamber(device, at, settings);
}

template <float Limits::*low, float Limits::*high>
constexpr std::array<Entry, 4> threshold_mbar(std::uint16_t index, const char* name) {
  return setting_in_milli(index, name, integer16, limit_range_mbar(high), read_limit_mbar<high>,
                          write_threshold_mbar<low, high>);
}

template <std::uint16_t Limits::*member>
constexpr std::array<Entry, 4> time_ms(std::uint16_t index, const char* name) {
  return setting_in_milli<kUnitSecond>(index, name, unsigned16, kAny, read_setting<member>,
                                       write_setting<member>);
}

template <auto Limits::*member>
constexpr Entry setting_type(std::uint16_t index, const char* name, float most) {
  return value(index, 0, kChambersApart, name, integer8, read_write, no, {0.0F, most, true},
               read_setting<member>, write_setting<member>);
}

// ---- the ramp: the time that it takes for what 6391h says is all ----

constexpr std::int32_t kAll_mbar = 10'000;
constexpr float kAll_kPa_ms_per_s = 1000.0F * kAll_mbar / kMbar_per_kPa;

template <float Limits::*rate_kPa_per_s>
Abort read_ramp_ms(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const float time_ms = kAll_kPa_ms_per_s / (device.settings.chamber(at.instance).*rate_kPa_per_s);
  bits = bits_of(numeric::nearest_within(time_ms, 1, UINT16_MAX, UINT16_MAX));
  return Abort::none;
}

template <float Limits::*rate_kPa_per_s>
Abort write_ramp_ms(Device& device, Place at, std::uint32_t bits) noexcept {
  Limits settings = device.settings.edited(at.instance);
  settings.*rate_kPa_per_s = kAll_kPa_ms_per_s / static_cast<float>(bits);
  return set_chamber(device, at, settings);
}

template <float Limits::*rate_kPa_per_s>
constexpr std::array<Entry, 4> ramp_ms(std::uint16_t index, const char* name) {
  return setting_in_milli<kUnitSecond>(index, name, unsigned16, {1.0F, UINT16_MAX, true},
                                       read_ramp_ms<rate_kPa_per_s>, write_ramp_ms<rate_kPa_per_s>);
}

// ---- the transducer: a straight line through the two ends of its signal window ----

struct Line {
  float low_V, high_V, low_kPa, high_kPa;
};

inline Line line_of(const Limits& settings) noexcept {
  return {settings.pressure_valid_low_V, settings.pressure_valid_high_V,
          config::pressure_kPa(settings, settings.pressure_valid_low_V),
          config::pressure_kPa(settings, settings.pressure_valid_high_V)};
}

constexpr float kMilli_per_V = 1000.0F;

template <float Line::*member>
constexpr float milli() noexcept {
  return member == &Line::low_V || member == &Line::high_V ? kMilli_per_V : kMbar_per_kPa;
}

template <float Line::*member>
Abort read_line(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = mbar_bits(line_of(device.settings.chamber(at.instance)).*member * milli<member>());
  return Abort::none;
}

/// The other end stays where it is. A window without width makes no line: that is no number, and refused.
template <float Line::*member>
Abort write_line(Device& device, Place at, std::uint32_t bits) noexcept {
  Limits settings = device.settings.edited(at.instance);
  Line line = line_of(settings);
  line.*member = static_cast<float>(static_cast<std::int16_t>(bits)) / milli<member>();
  settings.pressure_valid_low_V = line.low_V;
  settings.pressure_valid_high_V = line.high_V;
  settings.pressure_gain_kPa_per_V = (line.high_kPa - line.low_kPa) / (line.high_V - line.low_V);
  settings.pressure_offset_kPa = line.low_kPa - settings.pressure_gain_kPa_per_V * line.low_V;
  return set_chamber(device, at, settings);
}

template <float Line::*member, std::uint32_t unit>
constexpr std::array<Entry, 4> end_of_line(std::uint16_t index, const char* name) {
  return setting_in_milli<unit>(index, name, integer16, kAny, read_line<member>, write_line<member>);
}

// ---- rows ----

inline constexpr auto kPressureControlRows = joined(
    end_of_line<&Line::low_kPa, kUnitBar>(0x6120, "Transducer: minimum pressure"),
    end_of_line<&Line::high_kPa, kUnitBar>(0x6121, "Transducer: maximum pressure"),
    zero_only(0x6123, "Transducer: pressure offset"),
    end_of_line<&Line::low_V, kUnitVolt>(0x6124, "Transducer: minimum signal"),
    end_of_line<&Line::high_V, kUnitVolt>(0x6125, "Transducer: maximum signal"),

    setpoint_mbar<&C::setpoint_Pa>(0x6380, "Set point", Kept::no),
    in_mbar(0x6381, "Actual value", transmit, read_chamber_mbar<&C::actual_Pa>),
    in_mbar(0x6382, "Interface reference", no, read_line<&Line::high_kPa>),
    in_mbar(0x6390, "Demand value", transmit, read_chamber_mbar<&C::demand_Pa>),
    in_mbar(0x6391, "Reference value", no, fixed<kAll_mbar>),
    setpoint_mbar<&C::hold_setpoint_Pa>(0x6394, "Hold set point", Kept::application),

    limit_mbar<&Limits::pressure_high_kPa>(0x63A0, "Upper limit"),
    limit_mbar<&Limits::pressure_low_kPa>(0x63A1, "Lower limit"), one_only(0x63A2, "Scaling factor"),
    zero_only(0x63A3, "Scaling offset"), zero_only(0x63A4, "Zero correction"),

    setting_type<&Limits::ramp_type>(0x63B0, "Ramp: type (0 none, 1 one time, 2 two, 3 by quadrant: as 2)",
                                     3.0F),
    ramp_ms<&Limits::reference_ramp_kPa_per_s>(0x63B1, "Ramp: acceleration time"),
    ramp_ms<&Limits::reference_ramp_kPa_per_s>(0x63B2, "Ramp: acceleration time, positive"),
    zero_only<kUnitSecond>(0x63B3, "Ramp: acceleration time, negative", unsigned16),
    ramp_ms<&Limits::reference_fall_kPa_per_s>(0x63B4, "Ramp: deceleration time"),
    ramp_ms<&Limits::reference_fall_kPa_per_s>(0x63B5, "Ramp: deceleration time, positive"),
    zero_only<kUnitSecond>(0x63B6, "Ramp: deceleration time, negative", unsigned16),

    off_only(0x63C0, "Directional gain: type"), one_only(0x63C1, "Directional gain: factor"),
    off_only(0x63C2, "Dead band compensation: type"), zero_only(0x63C3, "Dead band compensation: A side"),
    zero_only(0x63C4, "Dead band compensation: B side"),
    zero_only(0x63C5, "Dead band compensation: threshold"),
    off_only(0x63C6, "Characteristic compensation: type"),

    in_mbar(0x63D0, "Control deviation", transmit, read_chamber_mbar<&C::deviation_Pa>),
    setting_type<&Limits::deviation_watched>(0x63D1, "Control deviation: monitoring type (0 off, 1 on)",
                                             1.0F),
    time_ms<&Limits::deviation_delay_ms>(0x63D2, "Control deviation: delay time"),
    threshold_mbar<&Limits::deviation_low_kPa, &Limits::deviation_high_kPa>(0x63D3,
                                                                            "Control deviation: threshold"),
    limit_mbar<&Limits::deviation_high_kPa>(0x63D4, "Control deviation: upper threshold"),
    limit_mbar<&Limits::deviation_low_kPa>(0x63D5, "Control deviation: lower threshold"),

    off_only(0x63E0, "Dither: type"), zero_only<kUnitVolt>(0x63E1, "Dither: amplitude"),
    zero_only<kUnitHertz, kPrefixNone>(0x63E2, "Dither: frequency"),

    setting_type<&Limits::target_watched>(0x63F0, "Target window: type (0 off, 1 on)", 1.0F),
    time_ms<&Limits::target_time_ms>(0x63F1, "Target window: time"),
    threshold_mbar<&Limits::target_low_kPa, &Limits::target_high_kPa>(0x63F2, "Target window: threshold"),
    limit_mbar<&Limits::target_high_kPa>(0x63F3, "Target window: upper threshold"),
    limit_mbar<&Limits::target_low_kPa>(0x63F4, "Target window: lower threshold"),
    value(0x63F5, 0, kChambersApart, "Target window: on target", unsigned8, read_only, transmit, kAny,
          read_on_target),

    value(0x67FF, 0, kChambersApart, "Device type of the module", unsigned32, constant, no, kAny,
          fixed<kModuleType>));

}  // namespace plenum::canopen::dictionary
