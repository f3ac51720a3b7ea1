#include "host-sim/client/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host-sim/client/abort_text.hpp"
#include "host-sim/client/board_facts.hpp"
#include "host-sim/trace/legible.hpp"

namespace plenum::host::client {
namespace {

using canopen::Abort;
using canopen::NmtCommand;
using canopen::NmtState;
namespace cob = canopen::cob;
namespace object = canopen::object;
namespace word = canopen::word;

constexpr std::uint16_t kSyncOverflow = 0x1019;
constexpr double kPoll_s = 0.01;  ///< between two looks at a state that changes at a tick's edge

std::uint8_t low_byte(unsigned value) {
  return static_cast<std::uint8_t>(value);
}

}  // namespace

std::optional<Emergency> decode_emergency(const CanFrame& frame) {
  if (frame.extended || frame.remote || frame.length != 8) return std::nullopt;
  if (frame.id <= cob::kEmergency || frame.id > cob::kEmergency + 127) return std::nullopt;
  const auto code = static_cast<std::uint16_t>(canopen::load_le(std::span(frame.data).first<2>()));
  return Emergency{.node_id = low_byte(frame.id - cob::kEmergency),
                   .code = code,
                   .error_register = frame.data[2],
                   .chamber = frame.data[3],
                   .lost_node = code == canopen::kHeartbeatLost ? frame.data[4] : std::uint8_t{0}};
}

Session::Session(Link& link, std::uint8_t node_id, const SessionConfig& config)
    : link_(link),
      node_id_(node_id),
      config_(config),
      sdo_(link, node_id, config.sdo, [this](const CanFrame& frame) { dispatch(frame); }) {
  if (node_id < 1 || node_id > 127) {
    throw std::invalid_argument(fmt::format("session: node id {}, expected 1..127", node_id));
  }
}

void Session::hear(const CanFrame& frame) {
  sdo_.observe(frame);
  dispatch(frame);
}

void Session::dispatch(const CanFrame& frame) {
  if (subscriber_) subscriber_({link_.now_s(), frame});
}

void Session::listen(double duration_s) {
  const double end_s = link_.now_s() + duration_s;
  for (double left_s = duration_s; left_s > 0.0; left_s = end_s - link_.now_s()) {
    const std::optional<CanFrame> frame = link_.receive(left_s);
    if (!frame) return;
    hear(*frame);
  }
}

bool Session::listen_until(const std::function<bool()>& done, double timeout_s) {
  const double end_s = link_.now_s() + timeout_s;
  while (!done()) {
    const double left_s = end_s - link_.now_s();
    const std::optional<CanFrame> frame = left_s > 0.0 ? link_.receive(left_s) : std::nullopt;
    if (!frame) return false;
    hear(*frame);
  }
  return true;
}

void Session::transmit(std::uint32_t id, std::span<const std::uint8_t> data) {
  CanFrame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.data.begin());
  link_.send(frame);
}

// ---- network ----

void Session::nmt(NmtCommand command) {
  transmit(cob::kNmt, std::array<std::uint8_t, 2>{static_cast<std::uint8_t>(command), node_id_});
}

NmtState Session::wait_heartbeat(double timeout_s) {
  const double end_s = link_.now_s() + timeout_s;
  for (double left_s = timeout_s; left_s > 0.0; left_s = end_s - link_.now_s()) {
    const std::optional<CanFrame> frame = link_.receive(left_s);
    if (!frame) break;
    hear(*frame);
    if (!frame->extended && !frame->remote && frame->id == cob::kHeartbeat + node_id_ && frame->length == 1) {
      return static_cast<NmtState>(frame->data[0] & 0x7FU);
    }
  }
  throw Timeout(fmt::format("node {}: no heartbeat within {:.3g} s, expected one on {:03X}h", node_id_,
                            timeout_s, cob::kHeartbeat + node_id_));
}

std::optional<NmtState> Session::wait_state(NmtState wanted, double timeout_s) {
  const double end_s = link_.now_s() + timeout_s;
  std::optional<NmtState> told;
  for (double left_s = timeout_s; left_s > 0.0 && told != wanted; left_s = end_s - link_.now_s()) {
    try {
      told = wait_heartbeat(left_s);
    } catch (const Timeout&) {
      break;
    }
  }
  return told;
}

void Session::wait_boot_up(double timeout_s) {
  const auto told = wait_state(NmtState::initialising, timeout_s);
  if (told == NmtState::initialising) return;
  throw Timeout(fmt::format("node {}: no boot-up message within {:.3g} s, expected one on {:03X}h{}",
                            node_id_, timeout_s, cob::kHeartbeat + node_id_,
                            told ? "; its heartbeat goes on: it has not heard the reset" : ""));
}

void Session::learn_sync() {
  constexpr std::uint32_t kIdentifier = 0x7FF;
  sync_id_ = read<std::uint32_t>(object::kSyncCobId, 0) & kIdentifier;
  sync_overflow_ = read<std::uint8_t>(kSyncOverflow, 0);
  sync_counter_ = 0;
  if (sync_overflow_ != 0) require_own_sync();
}

/// Two frames of one identifier and two counters would destroy each other on the bus.
void Session::require_own_sync() {
  constexpr double kListen_s = 0.1;
  const double end_s = link_.now_s() + kListen_s;
  for (double left_s = kListen_s; left_s > 0.0; left_s = end_s - link_.now_s()) {
    const std::optional<CanFrame> frame = link_.receive(left_s);
    if (!frame) return;
    hear(*frame);
    if (frame->extended || frame->remote || frame->id != sync_id_) continue;
    throw Refused(
        fmt::format("node {}: another master sends SYNC on {:03X}h, and SYNCs are counted (1019h = {}): "
                    "expected one master that does, or 1019h = 0",
                    node_id_, sync_id_, sync_overflow_));
  }
}

/// CiA 301, 7.2.5: the counter goes from 1 to 1019h.
void Session::send_sync() {
  if (sync_overflow_ == 0) {
    transmit(sync_id_, {});
    return;
  }
  sync_counter_ = sync_counter_ >= sync_overflow_ ? std::uint8_t{1} : low_byte(sync_counter_ + 1U);
  transmit(sync_id_, std::array<std::uint8_t, 1>{sync_counter_});
}

// ---- objects ----

TransferProgress Session::told(std::uint16_t index, std::uint8_t sub,
                               const TransferProgress& progress) const {
  return [this, index, sub, &progress](std::size_t done, std::optional<std::size_t> total) {
    tell({index, sub, done, total});
    if (progress) progress(done, total);
  };
}

std::uint32_t Session::read_bits(std::uint16_t index, std::uint8_t sub, std::size_t size) {
  const std::vector<std::uint8_t> bytes = sdo_read(index, sub);
  if (bytes.size() != size) {
    throw ProtocolError(fmt::format("node {}: reading {:04X}h:{} gave {} bytes, expected {}", node_id_, index,
                                    sub, bytes.size(), size));
  }
  return canopen::load_le(bytes);
}

void Session::write_bits(std::uint16_t index, std::uint8_t sub, std::uint32_t bits, std::size_t size) {
  std::array<std::uint8_t, 4> bytes{};
  canopen::store_le(bits, bytes);
  sdo_write(index, sub, std::span<const std::uint8_t>(bytes).first(size));
}

std::string Session::read_text(std::uint16_t index) {
  const std::vector<std::uint8_t> bytes = sdo_read(index, 0);
  return trace::legible({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

// ---- device control ----

std::uint16_t Session::control(std::uint16_t control_word, std::uint16_t bits, std::uint16_t wanted) {
  write<std::uint16_t>(object::kControlWord, 0, control_word);
  const double end_s = link_.now_s() + config_.state_timeout_s;
  std::uint16_t status = status_word();
  while ((status & bits) != wanted && link_.now_s() < end_s) {
    listen(kPoll_s);
    status = status_word();
  }
  return status;
}

void Session::request_state(std::uint16_t control_word) {
  const auto wanted = static_cast<std::uint16_t>((control_word & word::kStateMask) | word::kReady);
  constexpr std::uint16_t kShown = word::kStateMask | word::kReady;
  const std::uint16_t status = control(control_word, kShown, wanted);
  if ((status & kShown) == wanted) return;
  const auto fault = read_fault(*this);
  const std::string found =
      fmt::format("node {}: is in {}, expected {} within {} s{}", node_id_,
                  state_name(status, fault ? fault->code : std::uint16_t{0}), state_name(wanted, 0),
                  config_.state_timeout_s,
                  fault ? fmt::format(": fault {} stands, see plenum faults", fault_text(*fault)) : "");
  if ((status & word::kReady) == 0) throw Refused(found);
  throw Timeout(found);
}

void Session::take_to_init() {
  if ((status_word() & word::kStateMask) == 0) return;
  const std::uint16_t status = control(0, word::kStateMask, 0);
  if ((status & word::kStateMask) == 0) return;
  throw Timeout(fmt::format("node {}: is {}, expected INIT within {} s", node_id_, state_name(status, 0),
                            config_.state_timeout_s));
}

void Session::enable() {
  request_state(word::kDisabled);
  request_state(word::kHold);
  request_state(word::kActive);
}

void Session::reset_fault() {
  write<std::uint16_t>(object::kControlWord, 0, word::kDisabled);
  listen(2.0 * kPoll_s);  // the edge needs a tick that saw the bit low
  request_state(word::kDisabled | word::kResetFault);
  write<std::uint16_t>(object::kControlWord, 0, word::kDisabled);
}

// ---- models: upload_models() is in model_upload.cpp ----

std::vector<std::uint8_t> Session::download_model(std::uint8_t chamber) {
  try {
    return sdo_read_domain(object::nth(object::kActiveModel, chamber), 0);
  } catch (const SdoAbort& abort) {
    if (abort.code == static_cast<std::uint32_t>(Abort::no_data)) return {};
    throw;
  }
}

// ---- set points and capture ----

/// The order CiA 301 asks for: switch off, empty the mapping, fill it, activate it, switch on.
void Session::map_pdo(std::uint16_t communication, std::uint16_t mapping, std::uint32_t cob_id,
                      std::uint8_t transmission_type, std::span<const std::uint32_t> objects) {
  write(communication, 1, cob_id | cob::kInvalid);
  write<std::uint8_t>(mapping, 0, 0);
  for (std::size_t i = 0; i < objects.size(); ++i)
    write(mapping, low_byte(static_cast<unsigned>(i) + 1), objects[i]);
  write(mapping, 0, low_byte(static_cast<unsigned>(objects.size())));
  write(communication, 2, transmission_type);
  write(communication, 1, cob_id);
}

void Session::configure_setpoints(SetpointFormat format) {
  constexpr std::uint8_t kEachSync = 1;
  constexpr std::uint8_t kOnEvent = 255;
  const auto map = [this](std::uint32_t n, std::uint8_t type, std::span<const std::uint32_t> objects,
                          bool on) {
    const std::uint32_t cob_id = cob::kRpdo1 + 0x100 * n + node_id_;
    map_pdo(object::nth(object::kRpdoCommunication, n), object::nth(object::kRpdoMapping, n),
            on ? cob_id : cob_id | cob::kInvalid, type, objects);
  };
  if (format == SetpointFormat::pascal) {
    // the deadline of RPDO1 and 2 watches the stream; RPDO3 and 4 come with them
    for (std::uint32_t n = 0; n < 4; ++n) {
      const std::array<std::uint32_t, 2> objects{canopen::mapping_entry(object::kPascals + 2 * n, 1, 32),
                                                 canopen::mapping_entry(object::kPascals + 2 * n + 1, 1, 32)};
      map(n, kEachSync, objects, true);
    }
  } else {
    for (std::uint32_t n = 0; n < 2; ++n) {
      std::array<std::uint32_t, 4> objects{};
      for (std::uint32_t i = 0; i < 4; ++i) {
        objects[i] = canopen::mapping_entry(object::of_module(object::kSetpoint, 4 * n + i), 1, 16);
      }
      map(n, kEachSync, objects, true);
    }
    const std::array<std::uint32_t, 1> control{canopen::mapping_entry(object::kControlWord, 0, 16)};
    map(2, kOnEvent, control, true);
    map(3, kOnEvent, control, false);
  }
  setpoint_format_ = format;
}

void Session::send_setpoints(std::span<const double, kChambers> setpoints_Pa) {
  const double high_Pa = static_cast<double>(canopen::kSetpointHigh_Pa);
  for (std::size_t chamber = 0; chamber < setpoints_Pa.size(); ++chamber) {
    if (setpoints_Pa[chamber] >= 0.0 && setpoints_Pa[chamber] <= high_Pa) continue;
    throw std::invalid_argument(fmt::format("node {} chamber {}: set point {} Pa, expected 0..{} Pa",
                                            node_id_, chamber + 1, setpoints_Pa[chamber], high_Pa));
  }
  const bool pascal = setpoint_format_ == SetpointFormat::pascal;
  const std::size_t per_pdo = pascal ? 2 : 4;
  const std::size_t value_bytes = pascal ? 4 : 2;
  for (std::size_t first = 0; first < setpoints_Pa.size(); first += per_pdo) {
    std::array<std::uint8_t, 8> data{};
    for (std::size_t i = 0; i < per_pdo; ++i) {
      const double setpoint_Pa = setpoints_Pa[first + i];
      const std::uint32_t bits = pascal ? std::bit_cast<std::uint32_t>(static_cast<float>(setpoint_Pa))
                                        : static_cast<std::uint32_t>(std::lround(setpoint_Pa / 100.0));
      canopen::store_le(bits, std::span(data).subspan(i * value_bytes, value_bytes));
    }
    transmit(cob::kRpdo1 + 0x100 * static_cast<std::uint32_t>(first / per_pdo) + node_id_, data);
  }
}

/// The identifier of chamber 0 in a block that is free: the node's own, or the next one that is. The board's own stream has to be off.
std::uint32_t Session::free_stream_ids() {
  constexpr double kTick_s = 1e-6 * config::kTick_us;
  constexpr double kListen_s = 3.0 * kTick_s;  // whoever streams does so each tick
  listen(kTick_s);                             // what this board had under way
  std::array<bool, kStreamBlocks> taken{};
  const double end_s = link_.now_s() + kListen_s;
  for (double left_s = kListen_s; left_s > 0.0; left_s = end_s - link_.now_s()) {
    const std::optional<CanFrame> frame = link_.receive(left_s);
    if (!frame) break;
    hear(*frame);
    if (const auto block = stream_block(*frame)) taken.at(*block) = true;
  }
  for (std::uint32_t next = 0; next < kStreamBlocks; ++next) {
    const std::uint32_t block = (node_id_ - 1U + next) % kStreamBlocks;
    if (!taken.at(block)) return kStreamIds + kStreamBlock * block;
  }
  throw ChannelTaken(
      fmt::format("node {}: others stream on all {} blocks of identifiers from {:03X}h to {:03X}h, expected "
                  "one to be free",
                  node_id_, kStreamBlocks, kStreamIds, kStreamIds + kStreamBlock * kStreamBlocks - 1));
}

Stream Session::configure_stream(const StreamConfig& config) {
  if (config.every_ticks < 1 || config.every_ticks > 240) {
    throw std::invalid_argument(
        fmt::format("node {}: stream at every {} ticks, expected 1..240", node_id_, config.every_ticks));
  }
  stop_stream();
  const std::uint32_t first_cob_id = free_stream_ids();
  const auto lsb_m3 = static_cast<float>(config.largest_volume_m3 / 65535.0);
  write(object::kCodeScale, 2, lsb_m3);
  for (std::uint32_t chamber = 0; chamber < kChambers; ++chamber) {
    if ((std::uint32_t{config.chambers} >> chamber & 1U) == 0) continue;
    std::vector<std::uint32_t> objects{canopen::mapping_entry(object::kPascals + chamber, 2, 32)};
    if (config.position) {
      objects.push_back(canopen::mapping_entry(object::kPascals + chamber, 4, 32));
    } else {
      objects.push_back(canopen::mapping_entry(object::kCodes + chamber, 1, 16));
      objects.push_back(canopen::mapping_entry(object::kCodes + chamber, 2, 16));
    }
    map_each_tick(kStreamTpdo + chamber, first_cob_id + chamber, config.every_ticks, objects);
  }
  const std::uint32_t supply_cob_id = cob::kTpdo1 + 0x100 * kSupplyTpdo + node_id_;
  if (config.supply)
    map_each_tick(kSupplyTpdo, supply_cob_id, config.every_ticks,
                  std::array{canopen::mapping_entry(object::kSupply, 0, 32)});
  return {config, first_cob_id, supply_cob_id, static_cast<double>(lsb_m3)};
}

/// On event, the event timer being the pause and the inhibit time half a tick less: once in so many ticks. A SYNC that is late, or two in
/// one tick, cost no row.
void Session::map_each_tick(std::uint32_t tpdo, std::uint32_t cob_id, unsigned every_ticks,
                            std::span<const std::uint32_t> objects) {
  constexpr std::uint8_t kOnEvent = 255;
  constexpr unsigned kTick_ms = config::kTick_us / 1000, kTick_100us = config::kTick_us / 100;
  const std::uint16_t communication = object::nth(object::kTpdoCommunication, tpdo);
  write(communication, 1, cob::kInvalid | cob::kNoRtr);
  write(communication, 3, static_cast<std::uint16_t>(kTick_100us * every_ticks - kTick_100us / 2));
  write(communication, 5, static_cast<std::uint16_t>(kTick_ms * every_ticks));
  map_pdo(communication, object::nth(object::kTpdoMapping, tpdo), cob::kNoRtr | cob_id, kOnEvent, objects);
}

void Session::stop_stream() {
  for (std::size_t chamber = 0; chamber < kChambers; ++chamber) {
    write(object::nth(object::kTpdoCommunication, kStreamTpdo + chamber), 1, cob::kInvalid | cob::kNoRtr);
  }
}

}  // namespace plenum::host::client
