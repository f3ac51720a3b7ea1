#include "host-sim/dictionary/dbc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/dictionary/data_sheet.hpp"

namespace plenum::host::dictionary {
namespace {

using canopen::DataType;
using canopen::Device;
using canopen::MappedObject;
using canopen::Mapping;

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

/// What one count of a signal stands for.
struct Scale {
  double factor = 1.0;
  std::string unit;
};

/// Codes of the stream (2220h) have their LSBs in 2228h, of the same sub-index.
Scale scale_of(const Device& device, const ObjectValues& values, const MappedObject& object) {
  std::string unit = split(object.entry->name).unit;
  if (object.entry->index != canopen::object::kCodes)
    return {1.0, unit.empty() ? unit_of_record(device, object) : unit};
  const canopen::Found scale = canopen::find(canopen::object::kCodeScale, object.sub);
  std::uint32_t bits = 0;
  if (const auto found = values.find({canopen::object::kCodeScale, object.sub}); found != values.end()) {
    bits = found->second;
  } else {
    static_cast<void>(scale.entry->read_value(device, scale.place, bits));  // neither is refused
  }
  const std::string written = fmt::format("{}", std::bit_cast<float>(bits));  // 1e-07, not 1.00000001e-07
  return {std::strtod(written.c_str(), nullptr), split(scale.entry->name).unit};
}

/// Nine digits, and no exponent: not every reader of the format takes one.
std::string decimal(double value) {
  std::string text = fmt::format("{:.9g}", value);
  if (text.find('e') == std::string::npos) return text;
  const int places = 8 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  text = fmt::format("{:.{}f}", value, std::max(places, 0));
  if (text.find('.') != std::string::npos) text.erase(text.find_last_not_of('0') + 1);
  return text;
}

struct Message {
  std::string name;
  std::string sender, receiver;
  std::uint32_t id;
  Mapping mapping;
};

void append_message(std::string& text, std::string& value_types, const Device& device,
                    const ObjectValues& values, const Message& message) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "BO_ {} {}: {} {}\n", message.id, message.name, message.mapping.bytes, message.sender);
  unsigned bit = 0;
  std::set<std::string> names;
  for (std::size_t i = 0; i < message.mapping.count; ++i) {
    const MappedObject& object = message.mapping.object[i];
    const canopen::Entry& entry = *object.entry;
    std::string name = split(entry.name).name;
    if (entry.last_sub > entry.sub) name += fmt::format(" {}", object.sub - entry.sub + 1);
    if (entry.instances > 1) name += fmt::format(" chamber {}", object.instance + 1);
    if (!names.insert(name).second) names.insert(name += fmt::format(" again {}", i + 1));
    const Scale scale = scale_of(device, values, object);
    const Limits limits = limits_of(entry);
    fmt::format_to(out, " SG_ {} : {}|{}@1{} ({},0) [{}|{}] \"{}\" {}\n", identifier(name), bit,
                   8 * object.bytes, is_signed(entry.type) ? '-' : '+', decimal(scale.factor),
                   decimal(scale.factor * limits.low), decimal(scale.factor * limits.high), scale.unit,
                   message.receiver);
    if (entry.type == DataType::real32)
      value_types += fmt::format("SIG_VALTYPE_ {} {} : 1;\n", message.id, identifier(name));
    bit += 8U * object.bytes;
  }
  text += '\n';
}

/// The mapping in the object `index`; empty when that is switched off, or not known.
Mapping mapping_in(const ObjectValues& values, std::uint16_t index, bool receive) {
  const auto value = [&](std::size_t sub) {
    const auto found = values.find({index, static_cast<std::uint8_t>(sub)});
    return found == values.end() ? 0 : found->second;
  };
  Mapping mapping;
  for (std::size_t i = 0; i < mapping.packed.size(); ++i) mapping.packed[i] = value(i + 1);
  if (const auto abort = canopen::activate_mapping(mapping, static_cast<std::uint8_t>(value(0)), receive);
      abort != canopen::Abort::none) {
    throw std::invalid_argument(fmt::format("{:04X}h: a mapping that no board of this program has", index));
  }
  return mapping;
}

}  // namespace

std::string dbc(std::uint8_t node_id, const ObjectValues& values) {
  const auto sheet = std::make_unique<DataSheet>(canopen::Identity{});
  const std::string board = fmt::format("Board{}", node_id);
  constexpr const char* kMaster = "Master";
  std::string text = fmt::format("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {} {}\n\n", kMaster, board);
  std::string value_types, comments;
  std::set<std::uint32_t> described;  // the format has one message of an identifier
  const auto append = [&](std::uint16_t parameters, std::uint16_t mapping, const char* kind,
                          std::size_t number, bool receive) {
    const auto cob_id = values.find({static_cast<std::uint16_t>(parameters + number), 1});
    if (cob_id == values.end() || (cob_id->second & canopen::cob::kInvalid) != 0) return;
    const std::uint32_t id = cob_id->second & canopen::cob::kIdMask;
    const std::string name = fmt::format("{}_{}{}", board, kind, number + 1);
    if (!described.insert(id).second) {
      comments += fmt::format("CM_ BO_ {} \"{} has this identifier, too\";\n", id, name);
      return;
    }
    append_message(text, value_types, sheet->sheet.delivered(), values,
                   {.name = name,
                    .sender = receive ? kMaster : board,
                    .receiver = receive ? board : kMaster,
                    .id = id,
                    .mapping = mapping_in(values, static_cast<std::uint16_t>(mapping + number), receive)});
  };
  for (std::size_t n = 0; n < canopen::kRpdos; ++n)
    append(canopen::object::kRpdoCommunication, canopen::object::kRpdoMapping, "RPDO", n, true);
  for (std::size_t n = 0; n < canopen::kTpdos; ++n)
    append(canopen::object::kTpdoCommunication, canopen::object::kTpdoMapping, "TPDO", n, false);
  return text + comments + value_types;
}

}  // namespace plenum::host::dictionary
