#include "host-sim/client/pdo_directory.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/client/sdo_frames.hpp"
#include "host-sim/client/session.hpp"

namespace plenum::host::client {
namespace {

using canopen::DataType;
namespace cob = canopen::cob;
namespace object = canopen::object;

constexpr double kPa_per_mbar = 100.0;
constexpr double kNoPressure_mbar = -32768.0;  ///< what a NaN reads as

/// The pressures of CiA 408 are the only integers of 16 bits that a PDO carries.
bool in_millibar(const canopen::Entry& entry) {
  return entry.type == DataType::integer16;
}

// sub-indices of 1010h and 1011h
constexpr std::uint8_t kAllParameters = 1;
constexpr std::uint8_t kCommunicationParameters = 2;

bool is_on(std::uint32_t cob_id) {
  return (cob_id & cob::kInvalid) == 0;
}

bool has_identifier(std::uint32_t cob_id, const CanFrame& frame) {
  return (cob_id & cob::kIdMask) == frame.id;
}

}  // namespace

double number_of(DataType type, std::span<const std::uint8_t> bytes) {
  const std::uint32_t bits = canopen::load_le(bytes);
  switch (type) {
    case DataType::integer8:
      return static_cast<std::int8_t>(bits);
    case DataType::integer16:
      return static_cast<std::int16_t>(bits);
    case DataType::integer32:
      return static_cast<std::int32_t>(bits);
    case DataType::real32:
      return static_cast<double>(std::bit_cast<float>(bits));
    default:
      return bits;
  }
}

PdoDirectory::Node PdoDirectory::delivered(std::uint8_t node_id) {
  static const canopen::Communication of_any_node = canopen::delivered_communication();
  canopen::Communication communication = of_any_node;
  canopen::give_node_id(communication, node_id);
  const auto parameters = [](const canopen::PdoParameters& pdo) {
    return Parameters{pdo.cob_id, pdo.mapping.count, pdo.mapping.packed};
  };
  Node node;
  std::ranges::transform(communication.rpdo, node.rpdo.begin(),
                         [&](const canopen::Rpdo& rpdo) { return parameters(rpdo.parameters()); });
  std::ranges::transform(communication.tpdo, node.tpdo.begin(),
                         [&](const canopen::Tpdo& tpdo) { return parameters(tpdo.parameters); });
  return node;
}

void PdoDirectory::set(Node& node, const Value& value) {
  const auto of = [&value](auto& pdos, std::uint16_t communication, std::uint16_t mapping) {
    for (std::uint32_t n = 0; n < pdos.size(); ++n) {
      Parameters& pdo = pdos[n];
      if (value.index == object::nth(communication, n) && value.sub == 1) pdo.cob_id = value.bits;
      if (value.index != object::nth(mapping, n) || value.sub > canopen::kMappable) continue;
      if (value.sub == 0) {
        pdo.count = static_cast<std::uint8_t>(std::min<std::uint32_t>(value.bits, canopen::kMappable));
      } else {
        pdo.packed[value.sub - 1U] = value.bits;
      }
    }
  };
  of(node.rpdo, object::kRpdoCommunication, object::kRpdoMapping);
  of(node.tpdo, object::kTpdoCommunication, object::kTpdoMapping);
}

void PdoDirectory::hear(const CanFrame& frame) {
  if (frame.extended || frame.remote) return;
  const auto node_id = static_cast<std::uint8_t>(frame.id & 0x7FU);
  if (node_id == 0) return;
  const std::uint32_t function = frame.id & ~0x7FU;
  const auto known = known_.find(node_id);
  if (function == cob::kHeartbeat && frame.length == 1 && known != known_.end()) {
    const bool boot_up = frame.data[0] == static_cast<std::uint8_t>(canopen::NmtState::initialising);
    if (boot_up) known->second.now = known->second.stored;
  }
  if (frame.length != 8) return;
  if (function == cob::kSdoRequest) {
    if (known != known_.end()) return hear_request(known->second, frame);
    const Node node = delivered(node_id);
    hear_request(known_.emplace(node_id, Known{node, node}).first->second, frame);
  } else if (function == cob::kSdoResponse && known != known_.end()) {
    hear_answer(node_id, known->second, frame);
  }
}

/// A segment of a block may look like a request. What answers it does not look like the answer.
void PdoDirectory::hear_request(Known& known, const CanFrame& frame) {
  const std::span<const std::uint8_t, 8> data(frame.data);
  const std::uint8_t command = data[0];
  const bool writes = (command & 0xE2U) == 0x22U;                               // expedited
  const bool reads = (command & 0xE0U) == 0x40U || (command & 0xE3U) == 0xA0U;  // plainly, or in blocks
  known.request.reset();
  if (!writes && !reads) return;
  const auto index = static_cast<std::uint16_t>(canopen::load_le(data.subspan<1, 2>()));
  known.request = Request{writes, {index, data[3], writes ? canopen::load_le(sdo::expedited(data)) : 0}};
}

void PdoDirectory::hear_answer(std::uint8_t node_id, Known& known, const CanFrame& frame) {
  const std::span<const std::uint8_t, 8> data(frame.data);
  const std::optional<Request> request = std::exchange(known.request, std::nullopt);
  if (!request) return;
  Value value = request->value;
  const bool names_it = canopen::load_le(data.subspan<1, 2>()) == value.index && data[3] == value.sub;
  const bool is_done = request->write ? data[0] == 0x60 : (data[0] & 0xE2U) == 0x42U;
  if (!names_it || !is_done) return;
  if (!request->write) value.bits = canopen::load_le(sdo::expedited(data));
  set(known.now, value);
  const bool of_pdos = value.sub == kAllParameters || value.sub == kCommunicationParameters;
  if (!request->write || !of_pdos) return;
  if (value.index == object::kStore) known.stored = known.now;
  if (value.index == object::kRestore) known.stored = delivered(node_id);
}

void PdoDirectory::learn(Session& session) {
  const std::uint8_t node_id = session.node_id();
  Node node = delivered(node_id);
  const auto ask = [&](auto& pdos, std::uint16_t communication, std::uint16_t mapping) {
    for (std::uint32_t n = 0; n < pdos.size(); ++n) {
      Parameters& pdo = pdos[n];
      const std::uint16_t index = object::nth(mapping, n);
      pdo.cob_id = session.read<std::uint32_t>(object::nth(communication, n), 1);
      if (!is_on(pdo.cob_id)) continue;
      pdo.count =
          std::min(session.read<std::uint8_t>(index, 0), static_cast<std::uint8_t>(canopen::kMappable));
      for (std::uint8_t i = 0; i < pdo.count; ++i)
        pdo.packed[i] = session.read<std::uint32_t>(index, static_cast<std::uint8_t>(i + 1));
    }
  };
  ask(node.rpdo, object::kRpdoCommunication, object::kRpdoMapping);
  ask(node.tpdo, object::kTpdoCommunication, object::kTpdoMapping);
  known_.insert_or_assign(node_id, Known{node, node});
}

std::optional<Pdo> PdoDirectory::read(const CanFrame& frame) const {
  if (frame.extended || frame.remote) return std::nullopt;
  const auto among = [&frame](std::uint8_t node_id, const auto& pdos, bool receive,
                              auto&& is_it) -> std::optional<Pdo> {
    const auto found = std::ranges::find_if(pdos, is_it, &Parameters::cob_id);
    if (found == pdos.end()) return std::nullopt;
    const auto number = static_cast<unsigned>(found - pdos.begin()) + 1;
    return Pdo{node_id, receive, number, values(*found, receive, frame)};
  };
  const auto is_on_it = [&frame](std::uint32_t cob_id) {
    return is_on(cob_id) && has_identifier(cob_id, frame);
  };
  // who sends it comes first: another may have an RPDO for it
  for (const auto& [node_id, known] : known_) {
    if (auto pdo = among(node_id, known.now.tpdo, false, is_on_it)) return pdo;
  }
  const auto named = static_cast<std::uint8_t>(frame.id & 0x7FU);  // by the predefined connection set
  const auto of_named = known_.find(named);
  const bool is_known = of_named != known_.end();
  static const Node bases = delivered(0);
  const Node& node = is_known ? of_named->second.now : bases;
  const auto has_it = [&](std::uint32_t cob_id) {
    return has_identifier(is_known || (cob_id & cob::kIdMask) == 0 ? cob_id : cob_id + named, frame);
  };
  if (!is_known && named != 0) {
    if (auto pdo = among(named, node.tpdo, false, has_it)) return pdo;
  }
  for (const auto& [node_id, known] : known_) {
    if (auto pdo = among(node_id, known.now.rpdo, true, is_on_it)) return pdo;
  }
  // One that is off, as far as is known: that it is on comes as news.
  if (named == 0) return std::nullopt;
  auto pdo = among(named, node.tpdo, false, has_it);
  return pdo ? pdo : among(named, node.rpdo, true, has_it);
}

std::optional<std::vector<PdoValue>> PdoDirectory::values(const Parameters& pdo, bool receive,
                                                          const CanFrame& frame) {
  canopen::Mapping mapping;
  mapping.packed = pdo.packed;
  const bool is_known = canopen::activate_mapping(mapping, pdo.count, receive) == canopen::Abort::none;
  if (!is_known || mapping.count == 0 || mapping.bytes != frame.length) return std::nullopt;
  std::vector<PdoValue> values;
  std::size_t at = 0;
  for (const canopen::MappedObject& mapped : std::span(mapping.object).first(mapping.count)) {
    const bool is_pressure = in_millibar(*mapped.entry);
    double number = number_of(mapped.entry->type, std::span(frame.data).subspan(at, mapped.bytes));
    if (is_pressure)
      number = number == kNoPressure_mbar ? std::numeric_limits<double>::quiet_NaN() : kPa_per_mbar * number;
    values.push_back({mapped.entry, mapped.sub, mapped.instance, number, is_pressure});
    at += mapped.bytes;
  }
  return values;
}

}  // namespace plenum::host::client
