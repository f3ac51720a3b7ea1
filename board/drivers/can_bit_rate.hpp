// The bit rate that a CAN interface is set to, as the kernel tells it to anyone who asks (rtnetlink).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace plenum::board::drivers {

/// [bit/s]; empty where the interface has none, as a vcan. Throws std::runtime_error: what, where, expected.
std::optional<std::uint32_t> can_bit_rate(const std::string& interface);

/// The same of the kernel's answer, an RTM_NEWLINK: IFLA_LINKINFO of kind "can" > IFLA_INFO_DATA > IFLA_CAN_BITTIMING > bitrate
/// (linux/can/netlink.h). Whatever is cut short is left out.
std::optional<std::uint32_t> bit_rate_in(std::span<const std::byte> answer) noexcept;

}  // namespace plenum::board::drivers
