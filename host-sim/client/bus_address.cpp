#include "host-sim/client/bus_address.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "host-sim/client/can_link.hpp"
#include "host-sim/client/slcan_link.hpp"
#include "host-sim/client/socketcand_link.hpp"
#include "host-sim/wire/slcan.hpp"

namespace plenum::host::client {
namespace {

constexpr std::string_view kSocketcand = "socketcand:";
constexpr std::string_view kCan = "can:";
constexpr std::string_view kSlcan = "slcan:";

[[noreturn]] void refuse(std::string_view text, const std::string& found, std::string_view expected) {
  throw std::invalid_argument(fmt::format("--bus {}: {}, expected {}", text, found, expected));
}

std::uint16_t port_of(std::string_view text, std::string_view digits) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    refuse(text, fmt::format("'{}' is no port", digits), "a number from 0 to 65535");
  }
  return port;
}

/// HOST, HOST:PORT or [HOST]:PORT, then /CHANNEL.
SocketcandAddress socketcand_of(std::string_view text) {
  std::string_view rest = text.substr(kSocketcand.size());
  const std::size_t slash = rest.find('/');
  if (slash == std::string_view::npos) {
    refuse(text, "no channel", "socketcand:HOST:PORT/CHANNEL, as in socketcand:127.0.0.1:29536/can0");
  }
  SocketcandAddress address;
  address.channel = rest.substr(slash + 1);
  const bool spelled = std::all_of(address.channel.begin(), address.channel.end(),
                                   [](char c) { return c > ' ' && c <= '~' && c != '<' && c != '>'; });
  if (address.channel.empty() || address.channel.size() > wire::kChannelLength || !spelled) {
    refuse(text, fmt::format("'{}' is no channel", address.channel),
           fmt::format("1 to {} characters without spaces", wire::kChannelLength));
  }
  rest = rest.substr(0, slash);
  const bool bracketed = !rest.empty() && rest.front() == '[';
  const std::size_t close = rest.find(']');
  if (bracketed && close == std::string_view::npos) refuse(text, "'[' without ']'", "[ADDRESS]:PORT/CHANNEL");
  const std::size_t colon = rest.find(':', bracketed ? close : 0);
  address.host = bracketed ? rest.substr(1, close - 1) : rest.substr(0, colon);
  if (address.host.empty()) refuse(text, "no host", "socketcand:HOST:PORT/CHANNEL");
  if (colon != std::string_view::npos) address.port = port_of(text, rest.substr(colon + 1));
  return address;
}

CanAddress can_of(std::string_view text) {
  const std::string_view interface = text.substr(kCan.size());
  if (interface.empty()) refuse(text, "no interface", "can:IFACE, as in can:can0");
  return {std::string(interface)};
}

SlcanAddress slcan_of(std::string_view text) {
  std::string_view device = text.substr(kSlcan.size());
  SlcanAddress address;
  if (const std::size_t at = device.rfind('@'); at != std::string_view::npos) {
    const std::string_view digits = device.substr(at + 1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), address.bit_rate);
    const bool is_number = error == std::errc() && end == digits.data() + digits.size();
    if (!is_number || !wire::slcan_rate(address.bit_rate)) {
      refuse(text, fmt::format("'{}' is no bit rate of such adapters", digits),
             "10000, 20000, 50000, 100000, 125000, 250000, 500000, 800000 or 1000000");
    }
    device = device.substr(0, at);
  }
  if (device.empty()) refuse(text, "no terminal", "slcan:TTY, as in slcan:/dev/ttyACM0");
  address.device = device;
  return address;
}

std::string host_text(const std::string& host) {
  return host.find(':') == std::string::npos ? host : fmt::format("[{}]", host);
}

// What each kind of address is as text, and as a link.
std::string text_of(const InprocAddress&) {
  return "inproc";
}
std::string text_of(const SocketcandAddress& address) {
  return fmt::format("{}{}:{}/{}", kSocketcand, host_text(address.host), address.port, address.channel);
}
std::string text_of(const CanAddress& address) {
  return fmt::format("{}{}", kCan, address.interface);
}
std::string text_of(const SlcanAddress& address) {
  return fmt::format("{}{}@{}", kSlcan, address.device, address.bit_rate);
}

std::unique_ptr<Link> link_of(const InprocAddress&) {
  throw std::invalid_argument("--bus inproc: it is inside another program, expected a bus to connect to");
}
std::unique_ptr<Link> link_of(const SocketcandAddress& address) {
  return std::make_unique<SocketcandLink>(address);
}
std::unique_ptr<Link> link_of(const CanAddress& address) {
  return std::make_unique<CanLink>(address.interface);
}
std::unique_ptr<Link> link_of(const SlcanAddress& address) {
  return std::make_unique<SlcanLink>(address);
}

}  // namespace

BusAddress parse_bus(std::string_view text) {
  if (text == "inproc") return InprocAddress{};
  if (text.starts_with(kSocketcand)) return socketcand_of(text);
  if (text.starts_with(kCan)) return can_of(text);
  if (text.starts_with(kSlcan)) return slcan_of(text);
  refuse(text, "no such bus", fmt::format("inproc, {}", kOutsideForms));
}

std::string format_bus(const BusAddress& address) {
  return std::visit([](const auto& one) { return text_of(one); }, address);
}

std::unique_ptr<Link> open_link(const BusAddress& address) {
  return std::visit([](const auto& one) { return link_of(one); }, address);
}

}  // namespace plenum::host::client
