// Objects 1400h..1A0Bh: PDO communication and mapping (CiA 301, 7.5.2.35..38).
#pragma once

#include "firmware/canopen/dictionary/communication.hpp"

namespace plenum::canopen::dictionary {

// ---- PDO parameters ----

template <bool receive>
const PdoParameters& pdo(const Device& device, Place at) {
  if constexpr (receive) {
    return device.communication.rpdo[at.instance].parameters();
  } else {
    return device.communication.tpdo[at.instance].parameters;
  }
}

template <bool receive, class Change>
void change_pdo(Device& device, Place at, Change&& change) {
  if constexpr (receive) {
    device.communication.rpdo[at.instance].change(change);
  } else {
    change(device.communication.tpdo[at.instance].parameters);
  }
}

/// What a PDO was doing is over once its parameters change; but a stream that moves the machine must go on, whoever writes here
/// (Node::watch_setpoints): its watch ends with ACTIVE alone.
template <bool receive>
void restart_pdo(Device& device, Place at) {
  if constexpr (receive) {
    device.communication.rpdo[at.instance].latched = false;
  } else {
    Tpdo& tpdo = device.communication.tpdo[at.instance];
    tpdo.due = false;
    tpdo.ever_sent = false;
    tpdo.sync_started = false;
    tpdo.sync_count = 0;
    tpdo.since_sent_us = 0;
  }
}

template <bool receive, auto member>
Abort read_pdo(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = pdo<receive>(device, at).*member;
  return Abort::none;
}

template <bool receive, auto member>
Abort write_pdo(Device& device, Place at, std::uint32_t bits) noexcept {
  change_pdo<receive>(device, at, [bits](PdoParameters& parameters) {
    using Member = std::remove_reference_t<decltype(parameters.*member)>;
    parameters.*member = static_cast<Member>(bits);
  });
  return Abort::none;
}

template <bool receive>
Abort write_pdo_cob_id(Device& device, Place at, std::uint32_t bits) noexcept {
  // bit 30 of an RPDO means nothing, and may be set (CiA 301, 7.5.2.35)
  const Abort abort = check_cob_id(device, receive ? User::rpdo : User::tpdo, at.instance,
                                   pdo<receive>(device, at).cob_id, bits);
  if (abort != Abort::none) return abort;
  change_pdo<receive>(device, at, [bits](PdoParameters& parameters) { parameters.cob_id = bits; });
  restart_pdo<receive>(device, at);
  return Abort::none;
}

template <bool receive>
Abort write_transmission_type(Device& device, Place at, std::uint32_t bits) noexcept {
  if (bits > 240 && bits < 254) return Abort::value_range;  // reserved, or on remote request only
  change_pdo<receive>(device, at, [bits](PdoParameters& parameters) {
    parameters.transmission_type = static_cast<std::uint8_t>(bits);
  });
  restart_pdo<receive>(device, at);
  return Abort::none;
}

inline Abort write_inhibit_time(Device& device, Place at, std::uint32_t bits) noexcept {
  PdoParameters& parameters = device.communication.tpdo[at.instance].parameters;
  if (is_valid(parameters)) return Abort::device_state;
  parameters.inhibit_100us = static_cast<std::uint16_t>(bits);
  return Abort::none;
}

inline Abort write_sync_start(Device& device, Place at, std::uint32_t bits) noexcept {
  PdoParameters& parameters = device.communication.tpdo[at.instance].parameters;
  if (is_valid(parameters)) return Abort::device_state;
  parameters.sync_start = static_cast<std::uint8_t>(bits);
  return Abort::none;
}

template <bool receive>
Abort read_mapping_count(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = pdo<receive>(device, at).mapping.count;
  return Abort::none;
}

template <bool receive>
Abort write_mapping_count(Device& device, Place at, std::uint32_t bits) noexcept {
  if (is_valid(pdo<receive>(device, at))) return Abort::device_state;
  Abort abort = Abort::none;
  change_pdo<receive>(device, at, [bits, &abort](PdoParameters& parameters) {
    abort = activate_mapping(parameters.mapping, static_cast<std::uint8_t>(bits), receive);
  });
  return abort;
}

template <bool receive>
Abort read_mapping(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = pdo<receive>(device, at).mapping.packed[at.sub - 1U];
  return Abort::none;
}

/// A mapped object, or the reason why `packed` names none.
inline Abort resolve(std::uint32_t packed, bool receive, MappedObject& object) {
  const Found found = find(static_cast<std::uint16_t>(packed >> 16), static_cast<std::uint8_t>(packed >> 8));
  if (found.entry == nullptr) return found.abort;
  const Mappable mappable = found.entry->mappable;
  if (mappable == Mappable::no || (receive && mappable != Mappable::receive_and_transmit))
    return Abort::not_mappable;
  const std::size_t bytes = size_of(found.entry->type);
  if ((packed & 0xFFU) != 8 * bytes) return Abort::parameter_incompatible;
  object = {found.entry, found.place.instance, found.place.sub, static_cast<std::uint8_t>(bytes)};
  return Abort::none;
}

template <bool receive>
Abort write_mapping(Device& device, Place at, std::uint32_t bits) noexcept {
  const PdoParameters& now = pdo<receive>(device, at);
  if (is_valid(now) || now.mapping.count != 0) return Abort::device_state;
  MappedObject object;
  const Abort abort = bits == 0 ? Abort::none : resolve(bits, receive, object);
  if (abort != Abort::none) return abort;
  change_pdo<receive>(
      device, at, [bits, at](PdoParameters& parameters) { parameters.mapping.packed[at.sub - 1U] = bits; });
  return Abort::none;
}

using P = PdoParameters;

inline constexpr Entry kPdoRows[] = {
    highest<5>(0x1400, kEachRpdo, "RPDO communication parameter"),
    kept(of_node(value(0x1400, 1, kEachRpdo, "COB-ID used by RPDO", unsigned32, read_write, no, kAny,
                       read_pdo<true, &P::cob_id>, write_pdo_cob_id<true>))),
    kept(value(0x1400, 2, kEachRpdo, "Transmission type", unsigned8, read_write, no, kAny,
               read_pdo<true, &P::transmission_type>, write_transmission_type<true>)),
    kept(value(0x1400, 5, kEachRpdo, "Event timer (deadline) [ms]", unsigned16, read_write, no, kAny,
               read_pdo<true, &P::event_timer_ms>, write_pdo<true, &P::event_timer_ms>)),
    kept(named("RPDO mapping parameter",
               value(0x1600, 0, kEachRpdo, "Number of mapped objects", unsigned8, read_write, no, kAny,
                     read_mapping_count<true>, write_mapping_count<true>))),
    kept(value(0x1600, {1, kMappable}, kEachRpdo, "Mapped object", unsigned32, read_write, no, kAny,
               read_mapping<true>, write_mapping<true>)),
    highest<6>(0x1800, kEachTpdo, "TPDO communication parameter"),
    kept(of_node(value(0x1800, 1, kEachTpdo, "COB-ID used by TPDO", unsigned32, read_write, no, kAny,
                       read_pdo<false, &P::cob_id>, write_pdo_cob_id<false>))),
    kept(value(0x1800, 2, kEachTpdo, "Transmission type", unsigned8, read_write, no, kAny,
               read_pdo<false, &P::transmission_type>, write_transmission_type<false>)),
    kept(value(0x1800, 3, kEachTpdo, "Inhibit time [100 us]", unsigned16, read_write, no, kAny,
               read_pdo<false, &P::inhibit_100us>, write_inhibit_time)),
    kept(value(0x1800, 5, kEachTpdo, "Event timer [ms]", unsigned16, read_write, no, kAny,
               read_pdo<false, &P::event_timer_ms>, write_pdo<false, &P::event_timer_ms>)),
    kept(value(0x1800, 6, kEachTpdo, "SYNC start value", unsigned8, read_write, no, {0.0F, 240.0F, true},
               read_pdo<false, &P::sync_start>, write_sync_start)),
    kept(named("TPDO mapping parameter",
               value(0x1A00, 0, kEachTpdo, "Number of mapped objects", unsigned8, read_write, no, kAny,
                     read_mapping_count<false>, write_mapping_count<false>))),
    kept(value(0x1A00, {1, kMappable}, kEachTpdo, "Mapped object", unsigned32, read_write, no, kAny,
               read_mapping<false>, write_mapping<false>)),
};

}  // namespace plenum::canopen::dictionary
