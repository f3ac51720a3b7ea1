// The bit rate that a CAN interface is set to (rtnetlink): the kernel tells it to anyone who asks, and changes it for CAP_NET_ADMIN.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace plenum::board::drivers {

/// To within half a percent, which leaves the nodes of a bus what they need to stay in step (CiA 301 asks for less than one between any two).
constexpr bool is_near(std::uint64_t value, std::uint64_t wanted) noexcept {
  return (value > wanted ? value - wanted : wanted - value) * 200 <= wanted;
}

/// What a controller makes of its clock: of each bit one quantum, a first and a second segment; a quantum is `prescaler` periods.
struct BitTimingLimits {
  struct Range {
    std::uint32_t least = 0;
    std::uint32_t most = 0;
    std::uint32_t step = 1;
  };
  std::uint32_t clock_Hz = 0;
  Range first, second, prescaler;
};

/// An interface, as the kernel has it.
struct CanInterface {
  bool up = false;
  bool controller = false;                  ///< it has a bit rate to be set; a vcan is none
  std::optional<std::uint32_t> bit_rate;    ///< [bit/s]; empty: none was set yet, or it can have none
  std::optional<BitTimingLimits> limits{};  ///< empty where the driver states none
  std::vector<std::uint32_t>
      only{};              ///< [bit/s] the rates that it can run at, where its driver states these instead
  std::uint32_t most = 0;  ///< [bit/s] of its transceiver; 0: not stated

  /// Whether the controller's clock gives this rate [bit/s], as is_near() has it.
  bool can_run_at(std::uint32_t rate) const noexcept;
};

/// Empty: there is none of this name. Throws std::runtime_error: what, where, expected.
std::optional<CanInterface> can_interface(const std::string& name);

/// Takes a controller down, sets its rate [bit/s] and that the kernel ends a bus-off 100 ms later, and brings it up; after a refusal only
/// where it was up. A driver that cannot restart its controller keeps it off the bus after a bus-off: not a failure. Throws likewise.
void set_can_bit_rate(const std::string& name, std::uint32_t bit_rate);

/// What an RTM_NEWLINK, the kernel's answer, says: flags, and IFLA_LINKINFO of kind "can" > IFLA_INFO_DATA > IFLA_CAN_BITTIMING and its
/// neighbours (linux/can/netlink.h). Nothing of what is cut short.
CanInterface interface_in(std::span<const std::byte> answer);

/// The RTM_NEWLINK that sets a rate: the same attributes. The kernel works out the rest of the bit timing.
std::vector<std::byte> bit_rate_request(int interface_index, std::uint32_t bit_rate);
/// That which sets after how long the kernel ends a bus-off.
std::vector<std::byte> restart_request(int interface_index, std::uint32_t restart_ms);

}  // namespace plenum::board::drivers
