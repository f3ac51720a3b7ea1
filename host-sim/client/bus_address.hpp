// How a user names a bus: the argument of --bus.
//
//   inproc                           a rig simulated inside the program
//   socketcand:HOST:PORT/CHANNEL     a socketcand server, simulated or of a real bus; :PORT may be left out (29536),
//                                    an IPv6 address stands in brackets
//   can:IFACE                        a CAN interface of this machine (SocketCAN)
//   slcan:TTY@BITRATE                a serial CAN adapter; @BITRATE may be left out (1000000)
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "host-sim/client/link.hpp"
#include "host-sim/wire/socketcand.hpp"

namespace plenum::host::client {

struct InprocAddress {};

struct SocketcandAddress {
  std::string host;
  std::uint16_t port = wire::kSocketcandPort;
  std::string channel;
};

struct CanAddress {
  std::string interface;
};

struct SlcanAddress {
  std::string device;
  std::uint32_t bit_rate = 1'000'000;  ///< one that adapters have: wire::slcan_rate()
};

using BusAddress = std::variant<InprocAddress, SocketcandAddress, CanAddress, SlcanAddress>;

/// The forms of a bus outside the program, for a help text.
inline constexpr const char* kOutsideForms = "socketcand:HOST:PORT/CHANNEL, can:IFACE or slcan:TTY";

/// Throws std::invalid_argument: what, where, what was expected.
BusAddress parse_bus(std::string_view text);

/// The address as text that parses to it.
std::string format_bus(const BusAddress& address);

/// A link to a bus outside this program. Throws std::runtime_error when it cannot be reached, std::invalid_argument for
/// InprocAddress: whoever simulates the rig has the link.
std::unique_ptr<Link> open_link(const BusAddress& address);

}  // namespace plenum::host::client
