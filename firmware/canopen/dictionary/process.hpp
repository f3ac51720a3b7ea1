// Objects 2150h..2228h (own): values in SI units, health of the loop, streaming codes.
#pragma once

#include "firmware/canopen/dictionary/rows.hpp"

namespace plenum::canopen::dictionary {

inline float in_si(const Setpoint& pressure_Pa) noexcept {
  return static_cast<float>(pressure_Pa.value());
}
inline float in_si(float value) noexcept {
  return value;
}

template <auto member>
Abort read_chamber(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = bits_of(in_si(device.image.chamber[at.instance].*member));
  return Abort::none;
}

/// Of a set point, that it is of now.
template <Setpoint ChamberImage::*member>
void set_setpoint(Device& device, Place at, numeric::Scalar pressure_Pa) noexcept {
  device.image.chamber[at.instance].*member = pressure_Pa;
  if constexpr (member == &ChamberImage::setpoint_Pa)
    device.image.setpoints_came = static_cast<std::uint8_t>(device.image.setpoints_came | 1U << at.instance);
}

template <Setpoint ChamberImage::*member>
Abort write_setpoint(Device& device, Place at, std::uint32_t bits) noexcept {
  set_setpoint<member>(device, at, numeric::Scalar(std::bit_cast<float>(bits)));
  return Abort::none;
}

inline Abort write_preview(Device& device, Place, std::uint32_t bits) noexcept {
  device.image.preview_ticks = static_cast<std::uint8_t>(bits);
  return Abort::none;
}

template <std::uint32_t Counters::*member>
Abort read_counter(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = device.counters.*member;
  return Abort::none;
}

template <std::uint32_t (telemetry::LatencyHistogram::*figure)() const noexcept>
Abort read_latency(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = (device.image.latency.*figure)();
  return Abort::none;
}

inline Abort read_latency_bin(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = device.image.latency.count(at.sub - std::size_t{1});
  return Abort::none;
}

inline Abort read_command_code(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = telemetry::command_code(device.image.chamber[at.instance].command_V.in_core());
  return Abort::none;
}

inline Abort read_volume_code(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const numeric::Scalar volume_mL = device.image.chamber[at.instance].volume_m3.in_core();
  bits = bits_of(numeric::nearest_within(volume_mL * device.image.volume_code.per_mL, 0, 65535, 0));
  return Abort::none;
}

inline Abort read_volume_lsb(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = bits_of(device.image.volume_code.lsb_m3);
  return Abort::none;
}

inline Abort write_volume_lsb(Device& device, Place, std::uint32_t bits) noexcept {
  const auto lsb_m3 = std::bit_cast<float>(bits);
  device.image.volume_code = {.lsb_m3 = lsb_m3, .per_mL = numeric::Scalar(config::kM3_per_mL / lsb_m3)};
  return Abort::none;
}

inline Abort read_supply(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = bits_of(device.image.supply_Pa);
  return Abort::none;
}

inline Abort read_regulation(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = device.image.chamber[at.sub - std::size_t{1}].regulation;
  return Abort::none;
}

using C = ChamberImage;
using L = telemetry::LatencyHistogram;

inline constexpr Entry kProcessRows[] = {
    highest<4>(0x2150, kChambersNext, "Values in SI units"),
    value(0x2150, 1, kChambersNext, "Set point [Pa]", real32, read_write, receive_and_transmit,
          kSetpointRange, read_chamber<&C::setpoint_Pa>, write_setpoint<&C::setpoint_Pa>),
    value(0x2150, 2, kChambersNext, "Actual pressure [Pa]", real32, read_only, transmit, kAny,
          read_chamber<&C::actual_Pa>),
    value(0x2150, 3, kChambersNext, "Volume [m3]", real32, read_only, transmit, kAny,
          read_chamber<&C::volume_m3>),
    value(0x2150, 4, kChambersNext, "Position sensor [V]", real32, read_only, transmit, kAny,
          read_chamber<&C::position_V>),
    value(0x2158, 0, kOnce, "Supply pressure [Pa]", real32, read_only, transmit, kAny, read_supply),
    kept(value(0x2160, 0, kOnce, "Preview of the set point [ticks]", unsigned8, read_write, no,
               {0.0F, float{config::kMostPreview_ticks}, true}, read_image<&ProcessImage::preview_ticks>,
               write_preview)),
    highest<12>(0x2200, kOnce, "Health"),
    value(0x2200, 1, kOnce, "Ticks", unsigned32, read_only, transmit, kAny,
          read_image<&ProcessImage::tick_count>),
    value(0x2200, 2, kOnce, "Overruns", unsigned32, read_only, transmit, kAny,
          read_image<&ProcessImage::overrun_count>),
    value(0x2200, 3, kOnce, "Highest latency of a tick [us]", unsigned32, read_only, transmit, kAny,
          read_latency<&L::max_us>),
    value(0x2200, 4, kOnce, "Latency of 999 in 1000 ticks [us]", unsigned32, read_only, transmit, kAny,
          read_latency<&L::p999_us>),
    value(0x2200, 5, kOnce, "Age of the newest scan [us]", unsigned32, read_only, transmit, kAny,
          read_image<&ProcessImage::scan_age_us>),
    value(0x2200, 6, kOnce, "Frames received", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::received>),
    value(0x2200, 7, kOnce, "Frames rejected", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::rejected>),
    value(0x2200, 8, kOnce, "SYNCs received", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::sync>),
    value(0x2200, 9, kOnce, "Transmit queue overflows", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::queue_overflow>),
    value(0x2200, 10, kOnce, "TPDOs overwritten", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::pdo_overwritten>),
    value(0x2200, 11, kOnce, "SDO aborts", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::sdo_aborts>),
    value(0x2200, 12, kOnce, "Fixed-point results cut off", unsigned32, read_only, transmit, kAny,
          read_image<&ProcessImage::saturation_count>),
    highest<L::kBins>(0x2201, kOnce, "Ticks by latency"),
    value(0x2201, {1, L::kBins}, kOnce, "Ticks", unsigned32, read_only, no, kAny, read_latency_bin),
    highest<5>(0x2210, kChambersNext, "Regulator"),
    value(0x2210, 1, kChambersNext, "Feedforward [V]", real32, read_only, transmit, kAny,
          read_chamber<&C::feedforward_V>),
    value(0x2210, 2, kChambersNext, "Feedback [V]", real32, read_only, transmit, kAny,
          read_chamber<&C::feedback_V>),
    value(0x2210, 3, kChambersNext, "Command [V]", real32, read_only, transmit, kAny,
          read_chamber<&C::command_V>),
    value(0x2210, 4, kChambersNext, "Model residual [Pa]", real32, read_only, transmit, kAny,
          read_chamber<&C::residual_Pa>),
    value(0x2210, 5, kChambersNext, "Model drift [Pa]", real32, read_only, transmit, kAny,
          read_chamber<&C::drift_Pa>),
    highest<2>(0x2220, kChambersNext, "Stream codes"),
    value(0x2220, 1, kChambersNext, "Command code [10 V / 65535]", unsigned16, read_only, transmit, kAny,
          read_command_code),
    value(0x2220, 2, kChambersNext, "Volume code [2228h:2]", unsigned16, read_only, transmit, kAny,
          read_volume_code),
    highest<2>(0x2228, kOnce, "Scale of the stream codes"),
    value(0x2228, 1, kOnce, "Command code LSB [V]", real32, constant, no, kAny,
          fixed<std::bit_cast<std::uint32_t>(kCommandLsb_V)>),
    kept(value(0x2228, 2, kOnce, "Volume code LSB [m3]", real32, read_write, no, {1.0e-10F, 1.0e-4F, true},
               read_volume_lsb, write_volume_lsb)),
    highest<config::kChambers>(object::kRegulation, kOnce,
                               "Regulation (1 on target, 2 ramp runs, 4 limit touched, 8 deviates)"),
    value(object::kRegulation, {1, config::kChambers}, kOnce, "Of a chamber: regulation", unsigned8,
          read_only, transmit, kAny, read_regulation),
};

}  // namespace plenum::canopen::dictionary
