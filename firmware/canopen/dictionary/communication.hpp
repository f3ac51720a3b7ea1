// Objects 1000h..1200h: the device, its errors, its identifiers (CiA 301, 7.5.2).
#pragma once

#include "firmware/canopen/dictionary/rows.hpp"
#include "firmware/canopen/eds.hpp"

namespace plenum::canopen::dictionary {

template <std::uint32_t Identity::*member>
Abort read_identity(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = device.config.identity.*member;
  return Abort::none;
}

// ---- errors ----

inline Abort read_error_register(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = error_state(device.image).error_register;
  return Abort::none;
}

inline Abort read_history_count(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = device.history.count;
  return Abort::none;
}

inline Abort clear_history(Device& device, Place, std::uint32_t bits) noexcept {
  if (bits != 0) return Abort::value_range;
  device.history = {};
  return Abort::none;
}

inline Abort read_history(const Device& device, Place at, std::uint32_t& bits) noexcept {
  if (at.sub > device.history.count) return Abort::no_data;
  bits = device.history.newest_first[at.sub - 1U];
  return Abort::none;
}

// ---- identifiers ----

/// Identifiers that CiA 301 keeps for NMT, SDO and heartbeat.
constexpr bool is_restricted(std::uint32_t id) noexcept {
  return id <= 0x07F || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) ||
         (id >= 0x601 && id <= 0x67F) || (id >= 0x6E0 && id <= 0x6FF) || id >= 0x701;
}

/// What has an identifier within a node.
enum class User : std::uint8_t { sync, emergency, rpdo, tpdo };

/// Another object of this node has the identifier: it could not be told whose a frame is, and of an identifier that is heard and sent
/// two nodes of the bus are senders. Only RPDOs may share one. `number`: of the PDO that asks, from 0.
inline bool is_taken(const Device& device, std::uint32_t id, User by, std::size_t number) noexcept {
  const Communication& all = device.communication;
  const auto has = [id](std::uint32_t cob_id) { return (cob_id & (cob::kInvalid | cob::kIdMask)) == id; };
  bool taken =
      (by != User::sync && has(all.sync_cob_id)) || (by != User::emergency && has(all.emergency_cob_id));
  for (const Rpdo& one : all.rpdo) taken = taken || (by != User::rpdo && has(one.parameters().cob_id));
  for (std::size_t i = 0; i < kTpdos; ++i) {
    const bool itself = by == User::tpdo && i == number;
    taken = taken || (!itself && has(all.tpdo[i].parameters.cob_id));
  }
  return taken;
}

inline Abort write_sync_cob_id(Device& device, Place, std::uint32_t bits) noexcept {
  bits &= ~cob::kInvalid;  // of 1005h CiA 301 leaves bit 31 open, and older configurations set it
  // no SYNC producer, no 29-bit identifiers
  if ((bits & ~cob::kIdMask) != 0 || is_restricted(bits)) return Abort::value_range;
  if (is_taken(device, bits, User::sync, 0)) return Abort::value_range;
  device.communication.sync_cob_id = bits;
  return Abort::none;
}

// ---- SYNC, heartbeats of others, error behaviour ----

/// 0, or the counter's last value before it begins at 1 again. Fixed while the master tells a period.
inline Abort write_sync_overflow(Device& device, Place, std::uint32_t bits) noexcept {
  if (bits > 240) return Abort::value_too_high;
  if (bits == 1) return Abort::value_range;
  if (device.communication.cycle_period_us != 0) return Abort::device_state;
  device.communication.sync_overflow = static_cast<std::uint8_t>(bits);
  return Abort::none;
}

inline Abort read_heartbeat_consumer(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = device.communication.heartbeats.entry(at.sub - 1U);
  return Abort::none;
}

inline Abort write_heartbeat_consumer(Device& device, Place at, std::uint32_t bits) noexcept {
  return device.communication.heartbeats.set_entry(at.sub - 1U, bits);
}

/// Of an object that bit 31 switches off, `number` of its kind.
inline Abort check_cob_id(const Device& device, User user, std::size_t number, std::uint32_t old_bits,
                          std::uint32_t bits) {
  const std::uint32_t flags = user == User::emergency ? cob::kInvalid : cob::kInvalid | cob::kNoRtr;
  if ((bits & ~(cob::kIdMask | flags)) != 0) return Abort::value_range;
  const std::uint32_t id = bits & cob::kIdMask;
  const bool was_valid = (old_bits & cob::kInvalid) == 0;
  const bool stays_valid = (bits & cob::kInvalid) == 0;
  if (stays_valid && (is_restricted(id) || is_taken(device, id, user, number))) return Abort::value_range;
  // the identifier may change only while, or as, the object is switched off
  if (was_valid && stays_valid && id != (old_bits & cob::kIdMask)) return Abort::value_range;
  return Abort::none;
}

inline Abort write_emergency_cob_id(Device& device, Place, std::uint32_t bits) noexcept {
  std::uint32_t& cob_id = device.communication.emergency_cob_id;
  const Abort abort = check_cob_id(device, User::emergency, 0, cob_id, bits);
  if (abort == Abort::none) cob_id = bits;
  return abort;
}

// ---- storing ----

/// Bit 0: on command. Nothing is stored on its own but models.
constexpr std::uint32_t kOnCommand = 1;

template <StoreOrder::What what, std::uint32_t signature>
Abort order_store(Device& device, Place at, std::uint32_t bits) noexcept {
  if (bits != signature) return Abort::cannot_store;
  if (device.order.what != StoreOrder::What::none) return Abort::device_state;
  constexpr std::uint8_t kCommunicationSub = 2;
  const bool saves_settings = what == StoreOrder::What::store && at.sub != kCommunicationSub;
  if (saves_settings && !device.settings.intact())
    return Abort::hardware_error;  // damage would outlive a restart
  device.order = {.what = what, .sub = at.sub};
  return Abort::pending;
}

inline Abort order_outcome(const Device& device, Place) noexcept {
  return device.order.done ? device.order.result : Abort::pending;
}

constexpr WriteValue kOrderSave = order_store<StoreOrder::What::store, kSaveSignature>;
constexpr WriteValue kOrderLoad = order_store<StoreOrder::What::restore, kLoadSignature>;

template <std::uint32_t base>
Abort node_cob_id(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = base + device.config.node_id;
  return Abort::none;
}

// ---- electronic data sheet ----

inline std::size_t read_sheet(Device& device, Place, std::uint32_t offset,
                              std::span<std::uint8_t> bytes) noexcept {
  return device.sheet.read(offset, bytes);
}

inline std::uint32_t sheet_size(const Device& device, Place) noexcept {
  return device.sheet.size();
}

inline constexpr Entry kCommunicationRows[] = {
    value(0x1000, 0, kOnce, "Device type", unsigned32, constant, no, kAny, fixed<kDeviceType>),
    value(0x1001, 0, kOnce, "Error register", unsigned8, read_only, transmit, kAny, read_error_register),
    named("Pre-defined error field", value(0x1003, 0, kOnce, "Number of errors", unsigned8, read_write, no,
                                           kAny, read_history_count, clear_history)),
    value(0x1003, {1, kErrorHistory}, kOnce, "Error", unsigned32, read_only, no, kAny, read_history),
    kept(value(0x1005, 0, kOnce, "COB-ID SYNC", unsigned32, read_write, no, kAny,
               read_communication<&Communication::sync_cob_id>, write_sync_cob_id)),
    value(0x1006, 0, kOnce, "Communication cycle period [us]", unsigned32, read_write, no, kAny,
          read_communication<&Communication::cycle_period_us>,
          write_communication<&Communication::cycle_period_us>),
    bytes(0x1008, kOnce, "Manufacturer device name", visible_string, constant,
          read_string<&Identity::device_name>),
    bytes(0x1009, kOnce, "Manufacturer hardware version", visible_string, constant,
          read_string<&Identity::hardware_version>),
    bytes(0x100A, kOnce, "Manufacturer software version", visible_string, constant,
          read_string<&Identity::software_version>),
    highest<3>(0x1010, kOnce, "Store parameters"),
    waiting_for(order_outcome, value(0x1010, 1, kOnce, "Save all parameters", unsigned32, read_write, no,
                                     kAny, fixed<kOnCommand>, kOrderSave)),
    waiting_for(order_outcome, value(0x1010, 2, kOnce, "Save communication parameters", unsigned32,
                                     read_write, no, kAny, fixed<kOnCommand>, kOrderSave)),
    waiting_for(order_outcome, value(0x1010, 3, kOnce, "Save application parameters", unsigned32, read_write,
                                     no, kAny, fixed<kOnCommand>, kOrderSave)),
    highest<3>(0x1011, kOnce, "Restore default parameters"),
    waiting_for(order_outcome, value(0x1011, 1, kOnce, "Restore all default parameters", unsigned32,
                                     read_write, no, kAny, fixed<kOnCommand>, kOrderLoad)),
    waiting_for(order_outcome, value(0x1011, 2, kOnce, "Restore communication default parameters", unsigned32,
                                     read_write, no, kAny, fixed<kOnCommand>, kOrderLoad)),
    waiting_for(order_outcome, value(0x1011, 3, kOnce, "Restore application default parameters", unsigned32,
                                     read_write, no, kAny, fixed<kOnCommand>, kOrderLoad)),
    kept(of_node(value(0x1014, 0, kOnce, "COB-ID EMCY", unsigned32, read_write, no, kAny,
                       read_communication<&Communication::emergency_cob_id>, write_emergency_cob_id))),
    highest<HeartbeatConsumer::kWatches>(0x1016, kOnce, "Consumer heartbeat time"),
    kept(value(0x1016, {1, HeartbeatConsumer::kWatches}, kOnce, "Node id << 16 | longest pause [ms]",
               unsigned32, read_write, no, kAny, read_heartbeat_consumer, write_heartbeat_consumer)),
    kept(value(0x1017, 0, kOnce, "Producer heartbeat time [ms]", unsigned16, read_write, no, kAny,
               read_communication<&Communication::heartbeat_ms>,
               write_communication<&Communication::heartbeat_ms>)),
    highest<4>(0x1018, kOnce, "Identity object"),
    value(0x1018, 1, kOnce, "Vendor-ID", unsigned32, read_only, no, kAny,
          read_identity<&Identity::vendor_id>),
    value(0x1018, 2, kOnce, "Product code", unsigned32, read_only, no, kAny,
          read_identity<&Identity::product_code>),
    value(0x1018, 3, kOnce, "Revision number", unsigned32, read_only, no, kAny,
          read_identity<&Identity::revision>),
    value(0x1018, 4, kOnce, "Serial number", unsigned32, read_only, no, kAny,
          read_identity<&Identity::serial>),
    kept(value(0x1019, 0, kOnce, "Synchronous counter overflow value", unsigned8, read_write, no, kAny,
               read_communication<&Communication::sync_overflow>, write_sync_overflow)),
    stream(0x1021, "Store EDS", domain, read_sheet, sheet_size),
    value(0x1022, 0, kOnce, "Store format", unsigned8, constant, no, kAny, fixed<0>),  // plain text
    highest<2>(0x1029, kOnce, "Error behaviour"),
    kept(value(0x1029, 1, kOnce, "Communication error", unsigned8, read_write, no, {0.0F, 2.0F, true},
               read_communication<&Communication::on_communication_error>,
               write_communication<&Communication::on_communication_error>)),
    kept(value(0x1029, 2, kOnce, "Device error", unsigned8, read_write, no, {0.0F, 2.0F, true},
               read_communication<&Communication::on_device_error>,
               write_communication<&Communication::on_device_error>)),
    highest<2>(0x1200, kOnce, "SDO server parameter"),
    of_node(value(0x1200, 1, kOnce, "COB-ID client to server", unsigned32, read_only, no, kAny,
                  node_cob_id<cob::kSdoRequest>)),
    of_node(value(0x1200, 2, kOnce, "COB-ID server to client", unsigned32, read_only, no, kAny,
                  node_cob_id<cob::kSdoResponse>)),
};

}  // namespace plenum::canopen::dictionary
