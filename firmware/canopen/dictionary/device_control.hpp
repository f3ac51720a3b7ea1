// Objects 6040h..605Fh: device control (CiA 408).
#pragma once

#include <algorithm>
#include <string_view>

#include "firmware/canopen/dictionary/process.hpp"
#include "firmware/canopen/text_line.hpp"

namespace plenum::canopen::dictionary {

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

// ---- identity: 1018h in words ----

template <std::uint32_t Identity::*member>
std::size_t read_digits(Device& device, Place, std::uint32_t offset, std::span<std::uint8_t> bytes) noexcept {
  TextLine line;
  line.decimal(device.config.identity.*member);
  const std::string_view rest = line.text().substr(std::min<std::size_t>(offset, line.text().size()));
  const std::size_t count = std::min(bytes.size(), rest.size());
  std::copy_n(rest.begin(), count, bytes.begin());
  return count;
}

template <std::uint32_t Identity::*member>
std::uint32_t count_digits(const Device& device, Place) noexcept {
  TextLine line;
  line.decimal(device.config.identity.*member);
  return static_cast<std::uint32_t>(line.text().size());
}

inline std::span<const std::uint8_t> read_description(const Device&, Place) noexcept {
  return text_bytes("Regulates the pressure of eight pneumatic chambers");
}

inline Abort write_parameter_set_code(Device& device, Place, std::uint32_t bits) noexcept {
  device.image.parameter_set_code = bits;
  return Abort::none;
}

/// Bit m: 6043h takes the control mode m (own).
constexpr std::uint32_t kCapability = 1U << static_cast<unsigned>(ControlMode::pressure_open_loop) |
                                      1U << static_cast<unsigned>(ControlMode::pressure_closed_loop);

inline constexpr Entry kDeviceControlRows[] = {
    value(0x6040, 0, kOnce, "Control word", unsigned16, read_write, receive_and_transmit, kAny,
          read_image<&ProcessImage::control_word>, write_control_word),
    value(0x6041, 0, kOnce, "Status word", unsigned16, read_only, transmit, kAny,
          read_image<&ProcessImage::status_word>),
    value(0x6042, 0, kOnce, "Device mode", integer8, read_write, no, {1.0F, 1.0F, true}, fixed<1>, accept),
    value(0x6043, 0, kOnce, "Control mode", integer8, read_write, no, {-1.0F, 4.0F, true}, read_control_mode,
          write_control_mode),
    value(0x604E, 0, kOnce, "Error code", unsigned16, read_only, transmit, kAny, read_error_code),
    value(0x604F, 0, kOnce, "Local (0: the bus has control)", integer8, constant, no, kAny, fixed<0>),

    bytes(0x6050, kOnce, "Device version", visible_string, constant,
          read_string<&Identity::software_version>),
    stream(0x6051, "Device code number", visible_string, read_digits<&Identity::product_code>,
           count_digits<&Identity::product_code>),
    stream(0x6052, "Device serial number", visible_string, read_digits<&Identity::serial>,
           count_digits<&Identity::serial>),
    bytes(0x6053, kOnce, "Device description", visible_string, constant, read_description),
    bytes(0x6054, kOnce, "Device model description", visible_string, constant,
          read_string<&Identity::device_name>),
    bytes(0x6055, kOnce, "Device model URL", visible_string, read_only, read_string<&Identity::model_url>),
    kept(value(0x6056, 0, kOnce, "Device parameter set code", unsigned32, read_write, no, kAny,
               read_image<&ProcessImage::parameter_set_code>, write_parameter_set_code)),
    bytes(0x6057, kOnce, "Device vendor name", visible_string, constant, read_string<&Identity::vendor_name>),
    value(0x605F, 0, kOnce, "Device capability (bit m: control mode m)", unsigned32, constant, no, kAny,
          fixed<kCapability>),
};

}  // namespace plenum::canopen::dictionary
