#include "host-sim/client/bus_address.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "host-sim/client/socketcand_link.hpp"

namespace plenum::host::client {
namespace {

constexpr std::string_view kSocketcand = "socketcand:";

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

}  // namespace

BusAddress parse_bus(std::string_view text) {
  if (text == "inproc") return InprocAddress{};
  if (text.starts_with(kSocketcand)) return socketcand_of(text);
  refuse(text, "no such bus", fmt::format("inproc or {}", kOutsideForms));
}

std::string format_bus(const BusAddress& address) {
  const auto* socketcand = std::get_if<SocketcandAddress>(&address);
  if (socketcand == nullptr) return "inproc";
  const bool brackets = socketcand->host.find(':') != std::string::npos;
  return fmt::format("{}{}{}{}:{}/{}", kSocketcand, brackets ? "[" : "", socketcand->host,
                     brackets ? "]" : "", socketcand->port, socketcand->channel);
}

std::unique_ptr<Link> open_link(const BusAddress& address) {
  if (const auto* socketcand = std::get_if<SocketcandAddress>(&address)) {
    return std::make_unique<SocketcandLink>(*socketcand);
  }
  throw std::invalid_argument("--bus inproc: it is inside another program, expected a bus to connect to");
}

}  // namespace plenum::host::client
