// Objects 2300h..2317h (own): the log of the last ticks, and the excitation that fills it.
#pragma once

#include "firmware/canopen/dictionary/rows.hpp"
#include "firmware/telemetry/recorder.hpp"

namespace plenum::canopen::dictionary {

inline Abort read_capture(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const telemetry::Recorder& recorder = device.recorder;
  switch (at.sub) {
    case 1:
      bits = recorder.last_order();
      break;
    case 2:
      bits = recorder.selected();
      break;
    case 3:
      bits = recorder.length();
      break;
    case 4:
      bits = static_cast<std::uint32_t>(recorder.state());
      break;
    default:
      bits = recorder.rows();
      break;
  }
  return Abort::none;
}

inline Abort write_capture_order(Device& device, Place, std::uint32_t order) noexcept {
  return device.recorder.order(static_cast<std::uint8_t>(order)) ? Abort::none : Abort::value_range;
}

inline Abort write_capture_chamber(Device& device, Place, std::uint32_t chamber) noexcept {
  return device.recorder.select(static_cast<std::uint8_t>(chamber)) ? Abort::none : Abort::value_range;
}

inline Abort write_capture_length(Device& device, Place, std::uint32_t rows) noexcept {
  if (device.recorder.state() == telemetry::Recorder::State::recording) return Abort::device_state;
  return device.recorder.set_length(static_cast<std::uint16_t>(rows)) ? Abort::none : Abort::value_range;
}

/// A log that goes on is not read: its rows would not belong together.
inline Abort capture_is_frozen(const Device& device, Place, std::uint32_t&) noexcept {
  const bool frozen = device.recorder.state() == telemetry::Recorder::State::frozen;
  return frozen ? Abort::none : Abort::device_state;
}

inline std::size_t read_capture_buffer(Device& device, Place, std::uint32_t offset,
                                       std::span<std::uint8_t> bytes) noexcept {
  return device.recorder.read(offset, bytes);
}

inline std::uint32_t capture_buffer_size(const Device& device, Place) noexcept {
  return device.recorder.size();
}

template <float ExcitationImage::*member>
Abort read_excitation(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = bits_of(device.image.chamber[at.instance].excitation.*member);
  return Abort::none;
}

template <float ExcitationImage::*member>
Abort write_excitation(Device& device, Place at, std::uint32_t bits) noexcept {
  device.image.chamber[at.instance].excitation.*member = std::bit_cast<float>(bits);
  return Abort::none;
}

inline Abort read_seed(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = device.image.chamber[at.instance].excitation.seed;
  return Abort::none;
}

inline Abort write_seed(Device& device, Place at, std::uint32_t bits) noexcept {
  device.image.chamber[at.instance].excitation.seed = bits;
  return Abort::none;
}

using X = ExcitationImage;

inline constexpr Entry kCaptureRows[] = {
    highest<5>(0x2300, kOnce, "Capture"),
    value(0x2300, 1, kOnce, "Order (0 roll, 1 freeze, 2 record)", unsigned8, read_write, no,
          {0.0F, 2.0F, true}, read_capture, write_capture_order),
    value(0x2300, 2, kOnce, "Chamber, from 0", unsigned8, read_write, no, {0.0F, 7.0F, true}, read_capture,
          write_capture_chamber),
    value(0x2300, 3, kOnce, "Length [ticks]", unsigned16, read_write, no, {1.0F, 1024.0F, true}, read_capture,
          write_capture_length),
    value(0x2300, 4, kOnce, "State (0 rolling, 1 recording, 2 frozen)", unsigned8, read_only, no, kAny,
          read_capture),
    value(0x2300, 5, kOnce, "Rows held", unsigned16, read_only, no, kAny, read_capture),
    stream(object::kCaptureBuffer, "Capture: log of the chamber", domain, read_capture_buffer,
           capture_buffer_size, capture_is_frozen),
    highest<5>(0x2310, kChambersNext, "Excitation"),
    value(0x2310, 1, kChambersNext, "Excitation: seed", unsigned32, read_write, no, kAny, read_seed,
          write_seed),
    value(0x2310, 2, kChambersNext, "Excitation: command low [V]", real32, read_write, no, kCommandRange_V,
          read_excitation<&X::command_low_V>, write_excitation<&X::command_low_V>),
    value(0x2310, 3, kChambersNext, "Excitation: command high [V]", real32, read_write, no, kCommandRange_V,
          read_excitation<&X::command_high_V>, write_excitation<&X::command_high_V>),
    value(0x2310, 4, kChambersNext, "Excitation: pressure low [Pa]", real32, read_write, no, kPressureRange,
          read_excitation<&X::pressure_low_Pa>, write_excitation<&X::pressure_low_Pa>),
    value(0x2310, 5, kChambersNext, "Excitation: pressure high [Pa]", real32, read_write, no, kPressureRange,
          read_excitation<&X::pressure_high_Pa>, write_excitation<&X::pressure_high_Pa>),
};

}  // namespace plenum::canopen::dictionary
