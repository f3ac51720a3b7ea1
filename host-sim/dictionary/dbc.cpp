#include "host-sim/dictionary/dbc.hpp"

#include <fmt/format.h>

#include <cctype>
#include <iterator>
#include <memory>
#include <vector>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/dictionary/data_sheet.hpp"

namespace plenum::host::dictionary {
namespace {

using canopen::DataType;
using canopen::Device;
using canopen::MappedObject;
using canopen::PdoParameters;

/// "Actual pressure [Pa]": the name proper, and the unit.
struct NameAndUnit {
  std::string name, unit;
};

NameAndUnit split(std::string_view text) {
  const std::size_t open = text.rfind(" [");
  if (open == std::string_view::npos || !text.ends_with(']')) return {std::string(text), ""};
  return {std::string(text.substr(0, open)), std::string(text.substr(open + 2, text.size() - open - 3))};
}

/// A record {value, SI unit, prefix} states its unit in the codes of CiA 303-2.
std::string unit_of_record(const Device& device, const MappedObject& object) {
  const auto byte = [&](std::uint8_t sub, std::uint32_t& bits) {
    const canopen::Found found = canopen::find(object.entry->index, sub);
    return found.entry != nullptr && found.entry->access == canopen::Access::constant &&
           found.entry->read_value(device, found.place, bits) == canopen::Abort::none;
  };
  std::uint32_t unit = 0;
  std::uint32_t prefix = 0;
  if (object.entry->index < 0x6000 || object.sub != 1 || !byte(2, unit) || !byte(3, prefix)) return "";
  const std::string symbol = unit == 0x4E ? "bar" : unit == 0x03 ? "s" : fmt::format("unit{:02X}h", unit);
  return (prefix == 0xFD ? "m" : "") + symbol;
}

/// DBC names are those of C.
std::string identifier(std::string_view text) {
  std::string name;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      name += c;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  return name;
}

struct Limits {
  double low, high;
};

Limits limits_of(const canopen::Entry& entry) {
  if (entry.range.limited)
    return {static_cast<double>(entry.range.low), static_cast<double>(entry.range.high)};
  switch (entry.type) {
    case DataType::integer8:
      return {-128, 127};
    case DataType::integer16:
      return {-32768, 32767};
    case DataType::integer32:
      return {-2147483648.0, 2147483647};
    case DataType::unsigned8:
      return {0, 255};
    case DataType::unsigned16:
      return {0, 65535};
    case DataType::unsigned32:
      return {0, 4294967295.0};
    default:
      return {0, 0};  // not limited
  }
}

bool is_signed(DataType type) {
  return type == DataType::integer8 || type == DataType::integer16 || type == DataType::integer32 ||
         type == DataType::real32;
}

struct Message {
  const PdoParameters& pdo;
  std::string name;
  std::string sender, receiver;
  std::uint32_t id;
};

void append_message(std::string& text, std::string& value_types, const Device& device,
                    const Message& message) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "BO_ {} {}: {} {}\n", message.id, message.name, message.pdo.mapping.bytes,
                 message.sender);
  unsigned bit = 0;
  for (std::size_t i = 0; i < message.pdo.mapping.count; ++i) {
    const MappedObject& object = message.pdo.mapping.object[i];
    const canopen::Entry& entry = *object.entry;
    auto [name, unit] = split(entry.name);
    if (unit.empty()) unit = unit_of_record(device, object);
    if (entry.instances > 1) name += fmt::format(" chamber {}", object.instance + 1);
    const Limits limits = limits_of(entry);
    fmt::format_to(out, " SG_ {} : {}|{}@1{} (1,0) [{}|{}] \"{}\" {}\n", identifier(name), bit,
                   8 * object.bytes, is_signed(entry.type) ? '-' : '+', limits.low, limits.high, unit,
                   message.receiver);
    if (entry.type == DataType::real32)
      value_types += fmt::format("SIG_VALTYPE_ {} {} : 1;\n", message.id, identifier(name));
    bit += 8U * object.bytes;
  }
  text += '\n';
}

}  // namespace

std::string dbc(std::uint8_t node_id) {
  const auto sheet = std::make_unique<DataSheet>(canopen::Identity{});
  const Device& device = sheet->sheet.delivered();
  const std::string board = fmt::format("Board{}", node_id);
  constexpr const char* kMaster = "Master";
  std::string text = fmt::format("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {} {}\n\n", kMaster, board);
  std::string value_types;
  const auto append = [&](const PdoParameters& pdo, const char* kind, std::size_t number, bool receive) {
    if ((pdo.cob_id & canopen::cob::kInvalid) != 0) return;
    append_message(text, value_types, device,
                   {.pdo = pdo,
                    .name = fmt::format("{}_{}{}", board, kind, number + 1),
                    .sender = receive ? kMaster : board,
                    .receiver = receive ? board : kMaster,
                    .id = (pdo.cob_id & canopen::cob::kIdMask) + node_id});
  };
  const canopen::Communication& communication = device.communication;
  for (std::size_t n = 0; n < canopen::kRpdos; ++n) append(communication.rpdo[n].parameters, "RPDO", n, true);
  for (std::size_t n = 0; n < canopen::kTpdos; ++n)
    append(communication.tpdo[n].parameters, "TPDO", n, false);
  return text + value_types;
}

}  // namespace plenum::host::dictionary
