#include "firmware/canopen/object_dictionary.hpp"

#include <bit>
#include <type_traits>

#include "firmware/config/model_image.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::canopen {
namespace {

// ---- conversions ----

constexpr float kPa_per_mbar = 100.0F;
constexpr std::int32_t kInvalid_mbar = -32768;  ///< what a NaN pressure reads as: no pressure can be that low

bool is_finite(std::uint32_t real32_bits) {
  return (real32_bits & 0x7F80'0000U) != 0x7F80'0000U;
}

std::uint32_t bits_of(float value) {
  return std::bit_cast<std::uint32_t>(value);
}

std::uint32_t bits_of(std::int32_t value) {
  return static_cast<std::uint32_t>(value);
}

/// Nearest integer, saturating; `if_nan` for NaN. The limits must be exact in float.
std::int32_t round_saturating(float value, std::int32_t low, std::int32_t high, std::int32_t if_nan) {
  if (value != value) return if_nan;
  if (value <= static_cast<float>(low)) return low;
  if (value >= static_cast<float>(high)) return high;
  return static_cast<std::int32_t>(value < 0.0F ? value - 0.5F : value + 0.5F);
}

std::uint32_t mbar_bits(float pressure_Pa) {
  return bits_of(round_saturating(pressure_Pa / kPa_per_mbar, -32767, 32767, kInvalid_mbar));
}

std::uint32_t code_bits(float value, float lsb) {
  return bits_of(round_saturating(value / lsb, 0, 65535, 0));
}

/// The value of a small integer type, sign extended.
std::int32_t integer_value(DataType type, std::uint32_t bits) {
  switch (type) {
    case DataType::integer8:
      return static_cast<std::int8_t>(bits);
    case DataType::integer16:
      return static_cast<std::int16_t>(bits);
    case DataType::unsigned8:
      return static_cast<std::uint8_t>(bits);
    case DataType::unsigned16:
      return static_cast<std::uint16_t>(bits);
    default:
      return static_cast<std::int32_t>(bits);
  }
}

// ---- accessors: constants and plain members ----

template <std::uint32_t value>
Abort fixed(const Device&, Place, std::uint32_t& bits) noexcept {
  bits = value;
  return Abort::none;
}

template <auto member>
Abort read_image(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(device.image.*member);
  return Abort::none;
}

template <auto member>
Abort write_image(Device& device, Place, std::uint32_t bits) noexcept {
  using Member = std::remove_reference_t<decltype(device.image.*member)>;
  device.image.*member = static_cast<Member>(bits);
  return Abort::none;
}

template <float ChamberImage::*member>
Abort read_chamber(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = bits_of(device.image.chamber[at.instance].*member);
  return Abort::none;
}

template <float ChamberImage::*member>
Abort write_chamber(Device& device, Place at, std::uint32_t bits) noexcept {
  device.image.chamber[at.instance].*member = std::bit_cast<float>(bits);
  return Abort::none;
}

template <float ChamberImage::*member>
Abort read_chamber_mbar(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = mbar_bits(device.image.chamber[at.instance].*member);
  return Abort::none;
}

template <float ChamberImage::*member>
Abort write_chamber_mbar(Device& device, Place at, std::uint32_t bits) noexcept {
  device.image.chamber[at.instance].*member =
      kPa_per_mbar * static_cast<float>(static_cast<std::int16_t>(bits));
  return Abort::none;
}

Abort read_deviation_mbar(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const ChamberImage& chamber = device.image.chamber[at.instance];
  bits = mbar_bits(chamber.reference_Pa - chamber.actual_Pa);
  return Abort::none;
}

template <float ExcitationImage::*member>
Abort read_excitation(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = bits_of(device.image.excitation.*member);
  return Abort::none;
}

template <float ExcitationImage::*member>
Abort write_excitation(Device& device, Place, std::uint32_t bits) noexcept {
  device.image.excitation.*member = std::bit_cast<float>(bits);
  return Abort::none;
}

template <std::uint32_t Counters::*member>
Abort read_counter(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = device.counters.*member;
  return Abort::none;
}

template <std::uint32_t Identity::*member>
Abort read_identity(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = device.config.identity.*member;
  return Abort::none;
}

template <const char* Identity::*member>
std::span<const std::uint8_t> read_string(const Device& device, Place) noexcept {
  const char* text = device.config.identity.*member;
  std::size_t length = 0;
  while (length < kMaxDomainBytes && text[length] != '\0') ++length;
  return {reinterpret_cast<const std::uint8_t*>(text), length};  // bytes of a VISIBLE_STRING
}

template <auto member>
Abort read_communication(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(device.communication.*member);
  return Abort::none;
}

template <auto member>
Abort write_communication(Device& device, Place, std::uint32_t bits) noexcept {
  using Member = std::remove_reference_t<decltype(device.communication.*member)>;
  device.communication.*member = static_cast<Member>(bits);
  return Abort::none;
}

// ---- errors ----

Abort read_error_register(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = error_state(device.image).error_register;
  return Abort::none;
}

Abort read_error_code(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = error_state(device.image).code;
  return Abort::none;
}

Abort read_history_count(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = device.history.count;
  return Abort::none;
}

Abort clear_history(Device& device, Place, std::uint32_t bits) noexcept {
  if (bits != 0) return Abort::value_range;
  device.history = {};
  return Abort::none;
}

Abort read_history(const Device& device, Place at, std::uint32_t& bits) noexcept {
  if (at.sub > device.history.count) return Abort::no_data;
  bits = device.history.newest_first[at.sub - 1U];
  return Abort::none;
}

// ---- identifiers ----

Abort write_sync_cob_id(Device& device, Place, std::uint32_t bits) noexcept {
  if ((bits & ~cob::kIdMask) != 0) return Abort::value_range;  // no SYNC producer, no 29-bit identifiers
  device.communication.sync_cob_id = bits;
  return Abort::none;
}

/// Identifiers that CiA 301 keeps for NMT, SDO and heartbeat.
constexpr bool is_restricted(std::uint32_t id) noexcept {
  return id <= 0x07F || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) ||
         (id >= 0x601 && id <= 0x67F) || (id >= 0x6E0 && id <= 0x6FF) || id >= 0x701;
}

Abort check_cob_id(std::uint32_t old_bits, std::uint32_t bits, std::uint32_t allowed_flags) {
  if ((bits & ~(cob::kIdMask | allowed_flags)) != 0) return Abort::value_range;
  const std::uint32_t id = bits & cob::kIdMask;
  if ((bits & cob::kInvalid) == 0 && is_restricted(id)) return Abort::value_range;
  // the identifier may change only while, or as, the object is switched off
  const bool was_valid = (old_bits & cob::kInvalid) == 0;
  const bool stays_valid = (bits & cob::kInvalid) == 0;
  if (was_valid && stays_valid && id != (old_bits & cob::kIdMask)) return Abort::value_range;
  return Abort::none;
}

Abort write_emergency_cob_id(Device& device, Place, std::uint32_t bits) noexcept {
  const Abort abort = check_cob_id(device.communication.emergency_cob_id, bits, cob::kInvalid);
  if (abort == Abort::none) device.communication.emergency_cob_id = bits;
  return abort;
}

template <std::uint32_t base>
Abort node_cob_id(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = base + device.config.node_id;
  return Abort::none;
}

// ---- PDO parameters ----

template <bool receive>
PdoParameters& pdo(Device& device, Place at) {
  if constexpr (receive) {
    return device.communication.rpdo[at.instance].parameters;
  } else {
    return device.communication.tpdo[at.instance].parameters;
  }
}

template <bool receive>
const PdoParameters& pdo(const Device& device, Place at) {
  if constexpr (receive) {
    return device.communication.rpdo[at.instance].parameters;
  } else {
    return device.communication.tpdo[at.instance].parameters;
  }
}

bool is_valid(const PdoParameters& parameters) {
  return (parameters.cob_id & cob::kInvalid) == 0;
}

/// What a PDO was doing is over once its parameters change.
template <bool receive>
void restart_pdo(Device& device, Place at) {
  if constexpr (receive) {
    Rpdo& rpdo = device.communication.rpdo[at.instance];
    rpdo.latched = false;
    rpdo.watched = false;
  } else {
    Tpdo& tpdo = device.communication.tpdo[at.instance];
    tpdo.due = false;
    tpdo.ever_sent = false;
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
  PdoParameters& parameters = pdo<receive>(device, at);
  using Member = std::remove_reference_t<decltype(parameters.*member)>;
  parameters.*member = static_cast<Member>(bits);
  return Abort::none;
}

template <bool receive>
Abort write_pdo_cob_id(Device& device, Place at, std::uint32_t bits) noexcept {
  PdoParameters& parameters = pdo<receive>(device, at);
  const Abort abort = check_cob_id(parameters.cob_id, bits, cob::kInvalid | (receive ? 0U : cob::kNoRtr));
  if (abort != Abort::none) return abort;
  parameters.cob_id = bits;
  restart_pdo<receive>(device, at);
  return Abort::none;
}

template <bool receive>
Abort write_transmission_type(Device& device, Place at, std::uint32_t bits) noexcept {
  if (bits > 240 && bits < 254) return Abort::value_range;  // reserved, or on remote request only
  pdo<receive>(device, at).transmission_type = static_cast<std::uint8_t>(bits);
  restart_pdo<receive>(device, at);
  return Abort::none;
}

Abort write_inhibit_time(Device& device, Place at, std::uint32_t bits) noexcept {
  PdoParameters& parameters = pdo<false>(device, at);
  if (is_valid(parameters)) return Abort::device_state;
  parameters.inhibit_100us = static_cast<std::uint16_t>(bits);
  return Abort::none;
}

template <bool receive>
Abort read_mapping_count(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = pdo<receive>(device, at).mapping.count;
  return Abort::none;
}

template <bool receive>
Abort write_mapping_count(Device& device, Place at, std::uint32_t bits) noexcept {
  PdoParameters& parameters = pdo<receive>(device, at);
  if (is_valid(parameters)) return Abort::device_state;
  return activate_mapping(parameters.mapping, static_cast<std::uint8_t>(bits), receive);
}

template <bool receive>
Abort read_mapping(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = pdo<receive>(device, at).mapping.packed[at.sub - 1U];
  return Abort::none;
}

/// A mapped object, or the reason why `packed` names none.
Abort resolve(std::uint32_t packed, bool receive, MappedObject& object) {
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
  PdoParameters& parameters = pdo<receive>(device, at);
  if (is_valid(parameters) || parameters.mapping.count != 0) return Abort::device_state;
  MappedObject object;
  const Abort abort = bits == 0 ? Abort::none : resolve(bits, receive, object);
  if (abort == Abort::none) parameters.mapping.packed[at.sub - 1U] = bits;
  return abort;
}

// ---- models ----

Abort read_schema_hash(const Device&, Place, std::uint32_t& bits) noexcept {
  bits = config::schema_hash(config::ModelKind::tassa9);
  return Abort::none;
}

Abort read_schema_count(const Device&, Place, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(config::parameter_schema(config::ModelKind::tassa9).size());
  return Abort::none;
}

/// 1: IEEE 754 binary32, 2: fixed point.
constexpr std::uint32_t kScalarFormat = std::is_same_v<numeric::Scalar, float> ? 1 : 2;

Abort write_staged_model(Device& device, Place at, std::span<const std::uint8_t> image) noexcept {
  const config::ImageVerdict verdict = device.desk.stage(at.instance, image);
  switch (verdict.error) {
    case config::ImageError::none:
      return Abort::none;
    case config::ImageError::not_finite:
    case config::ImageError::out_of_range:
    case config::ImageError::not_admissible:
      return Abort::value_range;
    case config::ImageError::commit_pending:
      return Abort::device_state;
    default:
      return Abort::cannot_store;
  }
}

std::span<const std::uint8_t> read_active_model(const Device& device, Place at) noexcept {
  return device.desk.active_image(at.instance);
}

Abort write_commit_key(Device& device, Place, std::uint32_t key) noexcept {
  Communication& communication = device.communication;
  const config::CommitResult result =
      device.desk.commit(communication.commit_mask, communication.commit_crc, key);
  // one commit for one mask and CRC: a replayed key finds an empty mask
  communication.commit_mask = 0;
  communication.commit_crc = 0;
  switch (result) {
    case config::CommitResult::accepted:
      return Abort::none;
    case config::CommitResult::wrong_key:
      return Abort::value_range;
    case config::CommitResult::wrong_crc:
      return Abort::cannot_store;
    case config::CommitResult::nothing_staged:
    case config::CommitResult::not_now:
      return Abort::device_state;
  }
  return Abort::general;
}

Abort read_set_state(const Device& device, Place at, std::uint32_t& bits) noexcept {
  const config::SetState state = device.desk.state(at.instance);
  switch (at.sub) {
    case 1:
      bits = static_cast<std::uint32_t>(state.phase);
      break;
    case 2:
      bits = static_cast<std::uint32_t>(state.refusal.error);
      break;
    case 3:
      bits = state.active_crc;
      break;
    case 4:
      bits = state.generation;
      break;
    case 5:
      bits = state.refusal.parameter;
      break;
    case 6:
      bits = bits_of(state.refusal.value);
      break;
    case 7:
      bits = bits_of(state.refusal.low);
      break;
    default:
      bits = bits_of(state.refusal.high);
      break;
  }
  return Abort::none;
}

// ---- streaming codes ----

Abort read_command_code(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = code_bits(device.image.chamber[at.instance].command_V, kCommandLsb_V);
  return Abort::none;
}

Abort read_volume_code(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = code_bits(device.image.chamber[at.instance].volume_m3, device.communication.volume_lsb_m3);
  return Abort::none;
}

Abort read_volume_lsb(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = bits_of(device.communication.volume_lsb_m3);
  return Abort::none;
}

Abort write_volume_lsb(Device& device, Place, std::uint32_t bits) noexcept {
  device.communication.volume_lsb_m3 = std::bit_cast<float>(bits);
  return Abort::none;
}

// ---- control ----

Abort write_control_mode(Device& device, Place, std::uint32_t bits) noexcept {
  const auto mode = static_cast<ControlMode>(static_cast<std::int8_t>(bits));
  switch (mode) {
    case ControlMode::excitation:
    case ControlMode::pressure_open_loop:
    case ControlMode::pressure_closed_loop:
      device.image.control_mode = mode;
      return Abort::none;
  }
  return Abort::value_range;
}

Abort accept_device_mode(Device&, Place, std::uint32_t) noexcept {
  return Abort::none;
}  // its range allows only 1

Abort read_seed(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = device.image.excitation.seed;
  return Abort::none;
}

Abort write_seed(Device& device, Place, std::uint32_t bits) noexcept {
  device.image.excitation.seed = bits;
  return Abort::none;
}

// ---- the table ----

struct Many {
  std::uint8_t instances;
  std::uint16_t stride;
};
constexpr Many kOnce{1, 1};
constexpr Many kChambersNext{config::kChambers, 1};
constexpr Many kChambersApart{config::kChambers, object::kChamberStride};
constexpr Many kEachRpdo{kRpdos, 1};
constexpr Many kEachTpdo{kTpdos, 1};

struct Subs {
  std::uint8_t first;
  std::uint8_t last;
  constexpr Subs(int only) : first(static_cast<std::uint8_t>(only)), last(first) {}
  constexpr Subs(int first_sub, int last_sub)
      : first(static_cast<std::uint8_t>(first_sub)), last(static_cast<std::uint8_t>(last_sub)) {}
};

constexpr Range kAny{};
constexpr Range kSetpointRange{kSetpointLow_Pa, kSetpointHigh_Pa, true};
constexpr Range kSetpointRange_mbar{0.0F, 32767.0F, true};
constexpr Range kPressureRange{0.0F, kSetpointHigh_Pa, true};
constexpr Range kCommandRange_V{0.0F, 10.0F, true};

constexpr Entry value(std::uint16_t index, Subs subs, Many many, const char* name, DataType type,
                      Access access, Mappable mappable, Range range, ReadValue read,
                      WriteValue write = nullptr) {
  return {index,  subs.first, subs.last, many.instances, many.stride, name,    type,
          access, mappable,   range,     read,           write,       nullptr, nullptr};
}

constexpr Entry bytes(std::uint16_t index, Many many, const char* name, DataType type, Access access,
                      ReadBytes read, WriteBytes write = nullptr) {
  return {index,        0,    0,       many.instances, many.stride, name, type, access,
          Mappable::no, kAny, nullptr, nullptr,        read,        write};
}

template <std::uint32_t count>
constexpr Entry highest(std::uint16_t index, Many many) {
  return value(index, 0, many, "Highest sub-index supported", DataType::unsigned8, Access::constant,
               Mappable::no, kAny, fixed<count>);
}

using enum DataType;
using enum Access;
using enum Mappable;
using C = ChamberImage;
using X = ExcitationImage;
using P = PdoParameters;

constexpr std::uint32_t kUnitBar = 0x4E;
constexpr std::uint32_t kPrefixMilli = 0xFD;

constexpr Entry kTable[] = {
    // CiA 301: the device
    value(0x1000, 0, kOnce, "Device type", unsigned32, constant, no, kAny, fixed<kDeviceType>),
    value(0x1001, 0, kOnce, "Error register", unsigned8, read_only, transmit, kAny, read_error_register),
    value(0x1003, 0, kOnce, "Number of errors", unsigned8, read_write, no, kAny, read_history_count,
          clear_history),
    value(0x1003, {1, kErrorHistory}, kOnce, "Error", unsigned32, read_only, no, kAny, read_history),
    value(0x1005, 0, kOnce, "COB-ID SYNC", unsigned32, read_write, no, kAny,
          read_communication<&Communication::sync_cob_id>, write_sync_cob_id),
    bytes(0x1008, kOnce, "Manufacturer device name", visible_string, constant,
          read_string<&Identity::device_name>),
    bytes(0x1009, kOnce, "Manufacturer hardware version", visible_string, constant,
          read_string<&Identity::hardware_version>),
    bytes(0x100A, kOnce, "Manufacturer software version", visible_string, constant,
          read_string<&Identity::software_version>),
    value(0x1014, 0, kOnce, "COB-ID EMCY", unsigned32, read_write, no, kAny,
          read_communication<&Communication::emergency_cob_id>, write_emergency_cob_id),
    value(0x1017, 0, kOnce, "Producer heartbeat time [ms]", unsigned16, read_write, no, kAny,
          read_communication<&Communication::heartbeat_ms>,
          write_communication<&Communication::heartbeat_ms>),
    highest<4>(0x1018, kOnce),
    value(0x1018, 1, kOnce, "Vendor-ID", unsigned32, read_only, no, kAny,
          read_identity<&Identity::vendor_id>),
    value(0x1018, 2, kOnce, "Product code", unsigned32, read_only, no, kAny,
          read_identity<&Identity::product_code>),
    value(0x1018, 3, kOnce, "Revision number", unsigned32, read_only, no, kAny,
          read_identity<&Identity::revision>),
    value(0x1018, 4, kOnce, "Serial number", unsigned32, read_only, no, kAny,
          read_identity<&Identity::serial>),
    highest<2>(0x1200, kOnce),
    value(0x1200, 1, kOnce, "COB-ID client to server", unsigned32, read_only, no, kAny,
          node_cob_id<cob::kSdoRequest>),
    value(0x1200, 2, kOnce, "COB-ID server to client", unsigned32, read_only, no, kAny,
          node_cob_id<cob::kSdoResponse>),

    // CiA 301: PDO communication and mapping
    highest<5>(0x1400, kEachRpdo),
    value(0x1400, 1, kEachRpdo, "COB-ID used by RPDO", unsigned32, read_write, no, kAny,
          read_pdo<true, &P::cob_id>, write_pdo_cob_id<true>),
    value(0x1400, 2, kEachRpdo, "Transmission type", unsigned8, read_write, no, kAny,
          read_pdo<true, &P::transmission_type>, write_transmission_type<true>),
    value(0x1400, 5, kEachRpdo, "Event timer (deadline) [ms]", unsigned16, read_write, no, kAny,
          read_pdo<true, &P::event_timer_ms>, write_pdo<true, &P::event_timer_ms>),
    value(0x1600, 0, kEachRpdo, "Number of mapped objects", unsigned8, read_write, no, kAny,
          read_mapping_count<true>, write_mapping_count<true>),
    value(0x1600, {1, kMappable}, kEachRpdo, "Mapped object", unsigned32, read_write, no, kAny,
          read_mapping<true>, write_mapping<true>),
    highest<5>(0x1800, kEachTpdo),
    value(0x1800, 1, kEachTpdo, "COB-ID used by TPDO", unsigned32, read_write, no, kAny,
          read_pdo<false, &P::cob_id>, write_pdo_cob_id<false>),
    value(0x1800, 2, kEachTpdo, "Transmission type", unsigned8, read_write, no, kAny,
          read_pdo<false, &P::transmission_type>, write_transmission_type<false>),
    value(0x1800, 3, kEachTpdo, "Inhibit time [100 us]", unsigned16, read_write, no, kAny,
          read_pdo<false, &P::inhibit_100us>, write_inhibit_time),
    value(0x1800, 5, kEachTpdo, "Event timer [ms]", unsigned16, read_write, no, kAny,
          read_pdo<false, &P::event_timer_ms>, write_pdo<false, &P::event_timer_ms>),
    value(0x1A00, 0, kEachTpdo, "Number of mapped objects", unsigned8, read_write, no, kAny,
          read_mapping_count<false>, write_mapping_count<false>),
    value(0x1A00, {1, kMappable}, kEachTpdo, "Mapped object", unsigned32, read_write, no, kAny,
          read_mapping<false>, write_mapping<false>),

    // manufacturer area: models (own)
    highest<3>(0x2100, kOnce),
    value(0x2100, 1, kOnce, "Schema hash", unsigned32, constant, no, kAny, read_schema_hash),
    value(0x2100, 2, kOnce, "Parameter count", unsigned16, constant, no, kAny, read_schema_count),
    value(0x2100, 3, kOnce, "Scalar format", unsigned8, constant, no, kAny, fixed<kScalarFormat>),
    bytes(0x2110, kChambersNext, "Staged model image", domain, write_only, nullptr, write_staged_model),
    bytes(0x2118, kChambersNext, "Active model image", domain, read_only, read_active_model),
    highest<3>(0x2120, kOnce),
    value(0x2120, 1, kOnce, "Commit: chamber mask", unsigned8, read_write, no, kAny,
          read_communication<&Communication::commit_mask>, write_communication<&Communication::commit_mask>),
    value(0x2120, 2, kOnce, "Commit: CRC-32 of the images' CRCs", unsigned32, read_write, no, kAny,
          read_communication<&Communication::commit_crc>, write_communication<&Communication::commit_crc>),
    value(0x2120, 3, kOnce, "Commit: key", unsigned32, write_only, no, kAny, nullptr, write_commit_key),
    highest<8>(0x2128, kChambersNext),
    value(0x2128, 1, kChambersNext, "State of the set", unsigned8, read_only, no, kAny, read_set_state),
    value(0x2128, 2, kChambersNext, "Reason of refusal", unsigned8, read_only, no, kAny, read_set_state),
    value(0x2128, 3, kChambersNext, "CRC of the active image", unsigned32, read_only, no, kAny,
          read_set_state),
    value(0x2128, 4, kChambersNext, "Generation", unsigned32, read_only, no, kAny, read_set_state),
    value(0x2128, 5, kChambersNext, "Refused parameter", unsigned8, read_only, no, kAny, read_set_state),
    value(0x2128, {6, 8}, kChambersNext, "Refused value, its low and high limit", real32, read_only, no, kAny,
          read_set_state),

    // manufacturer area: values in SI units, and the health of the loop (own)
    highest<3>(0x2150, kChambersNext),
    value(0x2150, 1, kChambersNext, "Set point [Pa]", real32, read_write, receive_and_transmit,
          kSetpointRange, read_chamber<&C::setpoint_Pa>, write_chamber<&C::setpoint_Pa>),
    value(0x2150, 2, kChambersNext, "Actual pressure [Pa]", real32, read_only, transmit, kAny,
          read_chamber<&C::actual_Pa>),
    value(0x2150, 3, kChambersNext, "Volume [m3]", real32, read_only, transmit, kAny,
          read_chamber<&C::volume_m3>),
    value(0x2160, 0, kOnce, "Preview of the set point [ticks]", unsigned8, read_write, no, kAny,
          read_image<&ProcessImage::preview_ticks>, write_image<&ProcessImage::preview_ticks>),
    highest<8>(0x2200, kOnce),
    value(0x2200, 1, kOnce, "Ticks", unsigned32, read_only, transmit, kAny,
          read_image<&ProcessImage::tick_count>),
    value(0x2200, 2, kOnce, "Overruns", unsigned32, read_only, transmit, kAny,
          read_image<&ProcessImage::overrun_count>),
    value(0x2200, 3, kOnce, "Frames received", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::received>),
    value(0x2200, 4, kOnce, "Frames rejected", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::rejected>),
    value(0x2200, 5, kOnce, "SYNCs received", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::sync>),
    value(0x2200, 6, kOnce, "Transmit queue overflows", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::queue_overflow>),
    value(0x2200, 7, kOnce, "TPDOs overwritten", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::pdo_overwritten>),
    value(0x2200, 8, kOnce, "SDO aborts", unsigned32, read_only, transmit, kAny,
          read_counter<&Counters::sdo_aborts>),
    highest<4>(0x2210, kChambersNext),
    value(0x2210, 1, kChambersNext, "Feedforward [V]", real32, read_only, transmit, kAny,
          read_chamber<&C::feedforward_V>),
    value(0x2210, 2, kChambersNext, "Feedback [V]", real32, read_only, transmit, kAny,
          read_chamber<&C::feedback_V>),
    value(0x2210, 3, kChambersNext, "Command [V]", real32, read_only, transmit, kAny,
          read_chamber<&C::command_V>),
    value(0x2210, 4, kChambersNext, "Model residual [Pa]", real32, read_only, transmit, kAny,
          read_chamber<&C::residual_Pa>),
    highest<2>(0x2220, kChambersNext),
    value(0x2220, 1, kChambersNext, "Command code [10 V / 65535]", unsigned16, read_only, transmit, kAny,
          read_command_code),
    value(0x2220, 2, kChambersNext, "Volume code [2228h:2]", unsigned16, read_only, transmit, kAny,
          read_volume_code),
    highest<2>(0x2228, kOnce),
    value(0x2228, 1, kOnce, "Command code LSB [V]", real32, constant, no, kAny,
          fixed<std::bit_cast<std::uint32_t>(kCommandLsb_V)>),
    value(0x2228, 2, kOnce, "Volume code LSB [m3]", real32, read_write, no, {1.0e-10F, 1.0e-4F, true},
          read_volume_lsb, write_volume_lsb),
    highest<5>(0x2310, kOnce),
    value(0x2310, 1, kOnce, "Excitation: seed", unsigned32, read_write, no, kAny, read_seed, write_seed),
    value(0x2310, 2, kOnce, "Excitation: command low [V]", real32, read_write, no, kCommandRange_V,
          read_excitation<&X::command_low_V>, write_excitation<&X::command_low_V>),
    value(0x2310, 3, kOnce, "Excitation: command high [V]", real32, read_write, no, kCommandRange_V,
          read_excitation<&X::command_high_V>, write_excitation<&X::command_high_V>),
    value(0x2310, 4, kOnce, "Excitation: pressure low [Pa]", real32, read_write, no, kPressureRange,
          read_excitation<&X::pressure_low_Pa>, write_excitation<&X::pressure_low_Pa>),
    value(0x2310, 5, kOnce, "Excitation: pressure high [Pa]", real32, read_write, no, kPressureRange,
          read_excitation<&X::pressure_high_Pa>, write_excitation<&X::pressure_high_Pa>),

    // CiA 408: device control
    value(0x6040, 0, kOnce, "Control word", unsigned16, read_write, receive_and_transmit, kAny,
          read_image<&ProcessImage::control_word>, write_image<&ProcessImage::control_word>),
    value(0x6041, 0, kOnce, "Status word", unsigned16, read_only, transmit, kAny,
          read_image<&ProcessImage::status_word>),
    value(0x6042, 0, kOnce, "Device mode", integer8, read_write, no, {1.0F, 1.0F, true}, fixed<1>,
          accept_device_mode),
    value(0x6043, 0, kOnce, "Control mode", integer8, read_write, no, kAny,
          read_image<&ProcessImage::control_mode>, write_control_mode),
    value(0x604E, 0, kOnce, "Error code", unsigned16, read_only, transmit, kAny, read_error_code),

    // CiA 408: pressure control, per chamber; pressures are absolute, in mbar
    highest<3>(0x6380, kChambersApart),
    value(0x6380, 1, kChambersApart, "Set point", integer16, read_write, receive_and_transmit,
          kSetpointRange_mbar, read_chamber_mbar<&C::setpoint_Pa>, write_chamber_mbar<&C::setpoint_Pa>),
    value(0x6380, 2, kChambersApart, "Set point unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6380, 3, kChambersApart, "Set point prefix", integer8, constant, no, kAny, fixed<kPrefixMilli>),
    highest<3>(0x6381, kChambersApart),
    value(0x6381, 1, kChambersApart, "Actual value", integer16, read_only, transmit, kAny,
          read_chamber_mbar<&C::actual_Pa>),
    value(0x6381, 2, kChambersApart, "Actual value unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6381, 3, kChambersApart, "Actual value prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
    highest<3>(0x6391, kChambersApart),
    value(0x6391, 1, kChambersApart, "Reference value", integer16, read_only, transmit, kAny,
          read_chamber_mbar<&C::reference_Pa>),
    value(0x6391, 2, kChambersApart, "Reference value unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6391, 3, kChambersApart, "Reference value prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
    highest<3>(0x6394, kChambersApart),
    value(0x6394, 1, kChambersApart, "Hold set point", integer16, read_write, receive_and_transmit,
          kSetpointRange_mbar, read_chamber_mbar<&C::hold_setpoint_Pa>,
          write_chamber_mbar<&C::hold_setpoint_Pa>),
    value(0x6394, 2, kChambersApart, "Hold set point unit", unsigned8, constant, no, kAny, fixed<kUnitBar>),
    value(0x6394, 3, kChambersApart, "Hold set point prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
    highest<3>(0x63D0, kChambersApart),
    value(0x63D0, 1, kChambersApart, "Control deviation", integer16, read_only, transmit, kAny,
          read_deviation_mbar),
    value(0x63D0, 2, kChambersApart, "Control deviation unit", unsigned8, constant, no, kAny,
          fixed<kUnitBar>),
    value(0x63D0, 3, kChambersApart, "Control deviation prefix", integer8, constant, no, kAny,
          fixed<kPrefixMilli>),
};

/// Instance of `entry` that `index` names, or -1.
int instance_of(const Entry& entry, std::uint16_t index) {
  if (index < entry.index) return -1;
  const unsigned distance = static_cast<unsigned>(index) - entry.index;
  if (distance % entry.stride != 0) return -1;
  const unsigned instance = distance / entry.stride;
  return instance < entry.instances ? static_cast<int>(instance) : -1;
}

}  // namespace

std::span<const Entry> object_dictionary() noexcept {
  return kTable;
}

Found find(std::uint16_t index, std::uint8_t sub) noexcept {
  Abort abort = Abort::no_object;
  for (const Entry& entry : kTable) {
    const int instance = instance_of(entry, index);
    if (instance < 0) continue;
    if (sub >= entry.sub && sub <= entry.last_sub) {
      return {Abort::none, &entry, {static_cast<std::uint8_t>(instance), sub}};
    }
    abort = Abort::no_subindex;
  }
  return {abort, nullptr, {}};
}

bool admissible(const Entry& entry, std::uint32_t bits) noexcept {
  if (entry.type == DataType::real32) {
    if (!is_finite(bits)) return false;
    const float number = std::bit_cast<float>(bits);
    return !entry.range.limited || (number >= entry.range.low && number <= entry.range.high);
  }
  if (!entry.range.limited) return true;
  const auto number = static_cast<float>(integer_value(entry.type, bits));
  return number >= entry.range.low && number <= entry.range.high;
}

Abort write_object(Device& device, const Found& found, std::span<const std::uint8_t> bytes) noexcept {
  const Entry& entry = *found.entry;
  if (entry.access == Access::read_only || entry.access == Access::constant) return Abort::read_only;
  if (entry.write_bytes != nullptr) return entry.write_bytes(device, found.place, bytes);
  const std::size_t size = size_of(entry.type);
  if (bytes.size() > size) return Abort::length_too_high;
  if (bytes.size() < size) return Abort::length_too_low;
  const std::uint32_t bits = load_le(bytes);
  if (!admissible(entry, bits)) return Abort::value_range;
  return entry.write_value(device, found.place, bits);
}

Abort activate_mapping(Mapping& mapping, std::uint8_t count, bool receive) noexcept {
  if (count > kMappable) return Abort::pdo_length_exceeded;
  Mapping active = mapping;
  active.bytes = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Abort abort = resolve(active.packed[i], receive, active.object[i]);
    if (abort != Abort::none) return abort;
    active.bytes = static_cast<std::uint8_t>(active.bytes + active.object[i].bytes);
    if (active.bytes > 8) return Abort::pdo_length_exceeded;
  }
  active.count = count;
  mapping = active;
  return Abort::none;
}

bool carries_setpoint(const Mapping& mapping) noexcept {
  for (std::size_t i = 0; i < mapping.count; ++i) {
    const MappedObject& object = mapping.object[i];
    const std::uint16_t index = object.entry->index;
    if ((index == object::kSetpoint || index == object::kPascals) && object.sub == 1) return true;
  }
  return false;
}

}  // namespace plenum::canopen
