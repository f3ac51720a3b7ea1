#include "host-sim/client/lss_text.hpp"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "firmware/canopen/cia301.hpp"
#include "host-sim/client/lss_commands.hpp"

namespace plenum::host::client {
namespace {

using namespace lss;

constexpr std::array<const char*, kNumbers> kNames{"vendor", "product", "revision", "serial number"};
constexpr std::array<const char*, 6> kRanges{
    "vendor", "product", "revision from", "revision to", "serial number from", "serial number to"};

std::uint32_t number_in(std::span<const std::uint8_t, 8> bytes) {
  return canopen::load_le(bytes.subspan<1, 4>());
}

std::string unknown(std::span<const std::uint8_t, 8> bytes) {
  return fmt::format("unknown service {:02X}h", bytes[0]);
}

/// Which of `count` that a command begins, if it is one of them.
std::optional<unsigned> nth_of(unsigned command, unsigned first, std::size_t count) {
  return command >= first && command - first < count ? std::optional(command - first) : std::nullopt;
}

/// The services whose answer is an error code.
std::optional<const char*> configured(unsigned command) {
  switch (command) {
    case kConfigureNodeId:
      return "configure node id";
    case kConfigureBitTiming:
      return "configure bit timing";
    case kStore:
      return "store configuration";
    default:
      return {};
  }
}

}  // namespace

std::string lss_request_text(std::span<const std::uint8_t, 8> bytes) {
  const unsigned command = bytes[0];
  if (const auto nth = nth_of(command, kSwitchSelectively, kNumbers))
    return fmt::format("switch to configuration {} {:08X}h", kNames.at(*nth), number_in(bytes));
  if (const auto nth = nth_of(command, kIdentify, kRanges.size()))
    return fmt::format("identify {} {:08X}h", kRanges.at(*nth), number_in(bytes));
  if (const auto nth = nth_of(command, kInquire, kNumbers)) return fmt::format("inquire {}", kNames.at(*nth));
  switch (command) {
    case kSwitchGlobally:
      return bytes[1] == 0 ? "switch all to waiting" : "switch all to configuration";
    case kConfigureNodeId:
      return fmt::format("configure node id {}", bytes[1]);
    case kConfigureBitTiming:
      return fmt::format("configure bit timing, table {}, row {}", bytes[1], bytes[2]);
    case kActivateBitTiming:
      return fmt::format("activate bit timing in {} ms", canopen::load_le(bytes.subspan<1, 2>()));
    case kStore:
      return "store configuration";
    case kIdentifyUnconfigured:
      return "identify nodes without an id";
    case kFastscan:
      return fmt::format("fastscan {:08X}h, bit {}, number {}, next {}", number_in(bytes), bytes[5], bytes[6],
                         bytes[7]);
    case kInquireNodeId:
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
  if (const auto nth = nth_of(command, kInquire, kNumbers))
    return fmt::format("{} {:08X}h", kNames.at(*nth), number_in(bytes));
  switch (command) {
    case kSwitched:
      return "switched to configuration";
    case kIdentified:
      return "identified";
    case kUnconfigured:
      return "a node without an id is here";
    case kInquireNodeId:
      return fmt::format("node id {}", bytes[1]);
    default:
      return unknown(bytes);
  }
}

}  // namespace plenum::host::client
