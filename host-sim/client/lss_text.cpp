#include "host-sim/client/lss_text.hpp"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "firmware/canopen/cia301.hpp"

namespace plenum::host::client {
namespace {

constexpr std::array<const char*, 4> kNumbers{"vendor", "product", "revision", "serial number"};
constexpr std::array<const char*, 6> kRanges{
    "vendor", "product", "revision from", "revision to", "serial number from", "serial number to"};

std::uint32_t number_in(std::span<const std::uint8_t, 8> bytes) {
  return canopen::load_le(bytes.subspan<1, 4>());
}

std::string unknown(std::span<const std::uint8_t, 8> bytes) {
  return fmt::format("unknown service {:02X}h", bytes[0]);
}

/// The services whose answer is an error code.
std::optional<const char*> configured(unsigned command) {
  switch (command) {
    case 0x11:
      return "configure node id";
    case 0x13:
      return "configure bit timing";
    case 0x17:
      return "store configuration";
    default:
      return {};
  }
}

}  // namespace

std::string lss_request_text(std::span<const std::uint8_t, 8> bytes) {
  const unsigned command = bytes[0];
  if (command >= 0x40 && command <= 0x43)
    return fmt::format("switch to configuration {} {:08X}h", kNumbers.at(command - 0x40), number_in(bytes));
  if (command >= 0x46 && command <= 0x4B)
    return fmt::format("identify {} {:08X}h", kRanges.at(command - 0x46), number_in(bytes));
  if (command >= 0x5A && command <= 0x5D) return fmt::format("inquire {}", kNumbers.at(command - 0x5A));
  switch (command) {
    case 0x04:
      return bytes[1] == 0 ? "switch all to waiting" : "switch all to configuration";
    case 0x11:
      return fmt::format("configure node id {}", bytes[1]);
    case 0x13:
      return fmt::format("configure bit timing, table {}, row {}", bytes[1], bytes[2]);
    case 0x15:
      return fmt::format("activate bit timing in {} ms", canopen::load_le(bytes.subspan<1, 2>()));
    case 0x17:
      return "store configuration";
    case 0x4C:
      return "identify nodes without an id";
    case 0x51:
      return fmt::format("fastscan {:08X}h, bit {}, number {}, next {}", number_in(bytes), bytes[5], bytes[6],
                         bytes[7]);
    case 0x5E:
      return "inquire node id";
    default:
      return unknown(bytes);
  }
}

std::string lss_answer_text(std::span<const std::uint8_t, 8> bytes) {
  const unsigned command = bytes[0];
  if (const auto service = configured(command)) {
    return bytes[1] == 0 ? fmt::format("{}: done", *service)
                         : fmt::format("{}: refused, error {}", *service, bytes[1]);
  }
  if (command >= 0x5A && command <= 0x5D)
    return fmt::format("{} {:08X}h", kNumbers.at(command - 0x5A), number_in(bytes));
  switch (command) {
    case 0x44:
      return "switched to configuration";
    case 0x4F:
      return "identified";
    case 0x50:
      return "a node without an id is here";
    case 0x5E:
      return fmt::format("node id {}", bytes[1]);
    default:
      return unknown(bytes);
  }
}

}  // namespace plenum::host::client
