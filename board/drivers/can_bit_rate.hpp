// The bit rate that a CAN interface is set to (rtnetlink): the kernel tells it to anyone who asks, and changes it for CAP_NET_ADMIN.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace plenum::board::drivers {

/// An interface, as the kernel has it.
struct CanInterface {
  bool up = false;
  bool controller = false;                ///< it has a bit rate to be set; a vcan is none
  std::optional<std::uint32_t> bit_rate;  ///< [bit/s]; empty: none was set yet, or it can have none
};

/// Throws std::runtime_error: what, where, expected.
CanInterface can_interface(const std::string& name);

/// Takes a controller down, sets its rate [bit/s] and that the kernel ends a bus-off 100 ms later, and brings it up again; at its old
/// rate, if it has one, when the kernel refuses the new one. Throws likewise.
void set_can_bit_rate(const std::string& name, std::uint32_t bit_rate);

/// What an RTM_NEWLINK, the kernel's answer, says: flags, and IFLA_LINKINFO of kind "can" > IFLA_INFO_DATA > IFLA_CAN_BITTIMING > bitrate
/// (linux/can/netlink.h). Nothing of what is cut short.
CanInterface interface_in(std::span<const std::byte> answer) noexcept;

/// The RTM_NEWLINK that sets a rate: the same attributes, and IFLA_CAN_RESTART_MS. The kernel works out the rest of the bit timing.
std::vector<std::byte> bit_rate_request(int interface_index, std::uint32_t bit_rate);

}  // namespace plenum::board::drivers
