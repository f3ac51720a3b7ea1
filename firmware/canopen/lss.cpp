#include "firmware/canopen/lss.hpp"

#include <algorithm>

namespace plenum::canopen {
namespace {

constexpr unsigned kSwitchGlobally = 0x04;
constexpr unsigned kConfigureNodeId = 0x11;
constexpr unsigned kConfigureBitTiming = 0x13;
constexpr unsigned kStore = 0x17;
constexpr unsigned kSwitchSelectively = 0x40;  ///< to 43h, one number of the identity each
constexpr unsigned kSwitched = 0x44;
constexpr unsigned kIdentify = 0x46;  ///< to 4Bh: vendor, product, revision low and high, serial low and high
constexpr unsigned kIdentifyUnconfigured = 0x4C;
constexpr unsigned kIdentified = 0x4F;
constexpr unsigned kUnconfigured = 0x50;
constexpr unsigned kFastscan = 0x51;
constexpr unsigned kInquireIdentity = 0x5A;  ///< to 5Dh
constexpr unsigned kInquireNodeId = 0x5E;

constexpr std::uint8_t kDone = 0;
constexpr std::uint8_t kOutOfRange = 1;
constexpr std::uint8_t kStoreFailed = 2;

constexpr std::size_t kNumbers = 4;

std::array<std::uint32_t, kNumbers> numbers_of(const Identity& identity) {
  return {identity.vendor_id, identity.product_code, identity.revision, identity.serial};
}

std::uint32_t number_in(const LssSlave::Bytes& request) {
  return load_le(std::span(request).subspan<1, 4>());
}

bool answer(LssSlave::Bytes& response, unsigned command, std::uint8_t value = 0) {
  response = {static_cast<std::uint8_t>(command), value};
  return true;
}

/// One step of a sequence that must be gone through in order. Returns true at its end.
bool go_on(std::uint8_t& done, unsigned step, unsigned steps, bool matches) {
  done = static_cast<std::uint8_t>(matches && (step == 0 || step == done) ? step + 1 : 0);
  if (done != steps) return false;
  done = 0;
  return true;
}

}  // namespace

bool LssSlave::switches_to_waiting(const Bytes& request) noexcept {
  return request[0] == kSwitchGlobally && request[1] == 0;
}

bool LssSlave::request(Device& device, const Bytes& request, Bytes& response) noexcept {
  const unsigned command = request[0];
  if (command == kSwitchGlobally) {
    if (request[1] > 1) return false;
    wait();
    if (request[1] == 1) state_ = State::configuration;
    return false;
  }
  if (command >= kIdentify && command < kIdentify + 6) return identify(device, request, response);
  if (command == kIdentifyUnconfigured)
    return device.config.node_id == kUnconfiguredNodeId && answer(response, kUnconfigured);
  if (state_ == State::configuration) return configure(device, request, response);
  if (command >= kSwitchSelectively && command < kSwitchSelectively + kNumbers)
    return switch_selectively(device, request, response);
  return command == kFastscan && fastscan(device, request, response);
}

bool LssSlave::switch_selectively(const Device& device, const Bytes& request, Bytes& response) noexcept {
  const unsigned step = request[0] - kSwitchSelectively;
  const bool matches = numbers_of(device.config.identity)[step] == number_in(request);
  if (!go_on(selected_, step, kNumbers, matches)) return false;
  state_ = State::configuration;
  return answer(response, kSwitched);
}

bool LssSlave::identify(const Device& device, const Bytes& request, Bytes& response) noexcept {
  const Identity& identity = device.config.identity;
  const std::uint32_t number = number_in(request);
  const unsigned step = request[0] - kIdentify;
  const std::array<bool, 6> matches = {identity.vendor_id == number, identity.product_code == number,
                                       identity.revision >= number,  identity.revision <= number,
                                       identity.serial >= number,    identity.serial <= number};
  return go_on(identified_, step, matches.size(), matches[step]) && answer(response, kIdentified);
}

/// The master halves the range of one number after the other; only a board without a node id takes part.
bool LssSlave::fastscan(const Device& device, const Bytes& request, Bytes& response) noexcept {
  constexpr unsigned kRestart = 0x80;
  if (device.config.node_id != kUnconfiguredNodeId) return false;
  const unsigned lowest_bit = request[5];
  const unsigned number = request[6];
  const unsigned next = request[7];
  if (lowest_bit == kRestart) {
    scanned_ = 0;
    return answer(response, kIdentified);
  }
  if (lowest_bit > 31 || number >= kNumbers || next >= kNumbers || number != scanned_) return false;
  const std::uint32_t differ = numbers_of(device.config.identity)[number] ^ number_in(request);
  if (differ >> lowest_bit != 0) return false;
  if (lowest_bit == 0) {
    if (next < number) state_ = State::configuration;  // the last number is known
    scanned_ = static_cast<std::uint8_t>(next);
  }
  return answer(response, kIdentified);
}

bool LssSlave::configure(Device& device, const Bytes& request, Bytes& response) noexcept {
  const unsigned command = request[0];
  if (command >= kInquireIdentity && command < kInquireIdentity + kNumbers) {
    answer(response, command);
    store_le(numbers_of(device.config.identity)[command - kInquireIdentity],
             std::span(response).subspan<1, 4>());
    return true;
  }
  switch (command) {
    case kInquireNodeId:
      return answer(response, command, device.config.node_id);
    case kConfigureNodeId: {
      const std::uint8_t node_id = request[1];
      if (node_id != kUnconfiguredNodeId && (node_id == 0 || node_id > kMaxNodeId))
        return answer(response, command, kOutOfRange);
      given_node_id_ = node_id;
      return answer(response, command, kDone);
    }
    case kConfigureBitTiming: {
      const std::size_t row = request[2];
      const bool runs = row < kBitRates_kbit.size() && (device.config.bit_rates >> row & 1U) != 0;
      if (request[1] != 0 || !runs || kBitRates_kbit[row] == 0) return answer(response, command, kOutOfRange);
      given_bit_rate_kbit_ = kBitRates_kbit[row];
      return answer(response, command, kDone);
    }
    case kStore:
      return store(device, response);
    default:
      return false;
  }
}

bool LssSlave::store(Device& device, Bytes& response) noexcept {
  if (device.order.what != StoreOrder::What::none) return answer(response, kStore, kStoreFailed);
  device.order = {};
  device.order.what = StoreOrder::What::lss;
  device.order.lss = {.node_id = given_node_id_, .bit_rate_kbit = given_bit_rate_kbit_};
  storing_ = true;
  storing_us_ = 0;
  return false;
}

bool LssSlave::elapse(Device& device, std::uint32_t elapsed_us, Bytes& response) noexcept {
  const bool done = device.order.what == StoreOrder::What::lss && device.order.done;
  const bool failed = !done || device.order.result != Abort::none;
  if (done) device.order = {};
  if (!storing_) return false;
  storing_us_ += std::min(elapsed_us, device.config.store_timeout_us);
  if (!done && storing_us_ < device.config.store_timeout_us) return false;
  storing_ = false;
  return answer(response, kStore, failed ? kStoreFailed : kDone);
}

}  // namespace plenum::canopen
