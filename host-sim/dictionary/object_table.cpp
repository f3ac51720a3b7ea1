#include "host-sim/dictionary/object_table.hpp"

#include <fmt/format.h>

#include "firmware/canopen/object_dictionary.hpp"

namespace plenum::host::dictionary {
namespace {

using canopen::DataType;
using canopen::Entry;

const char* type_name(DataType type) {
  switch (type) {
    case DataType::integer8:
      return "INTEGER8";
    case DataType::integer16:
      return "INTEGER16";
    case DataType::integer32:
      return "INTEGER32";
    case DataType::unsigned8:
      return "UNSIGNED8";
    case DataType::unsigned16:
      return "UNSIGNED16";
    case DataType::unsigned32:
      return "UNSIGNED32";
    case DataType::real32:
      return "REAL32";
    case DataType::visible_string:
      return "VISIBLE_STRING";
    case DataType::domain:
      return "DOMAIN";
  }
  return "?";
}

const char* access_name(canopen::Access access) {
  switch (access) {
    case canopen::Access::constant:
      return "const";
    case canopen::Access::read_only:
      return "ro";
    case canopen::Access::read_write:
      return "rw";
    case canopen::Access::write_only:
      return "wo";
  }
  return "?";
}

const char* mappable_name(canopen::Mappable mappable) {
  switch (mappable) {
    case canopen::Mappable::no:
      return "";
    case canopen::Mappable::transmit:
      return "TPDO";
    case canopen::Mappable::receive_and_transmit:
      return "RPDO, TPDO";
  }
  return "?";
}

std::string index_text(const Entry& entry) {
  std::string text = fmt::format("{:04X}h", entry.index);
  if (entry.instances == 1) return text;
  const char* letter = entry.index < 0x2000 ? "n" : "c";
  if (entry.stride == 1) return text + " + " + letter;
  return text + fmt::format(" + {:X}h {}", entry.stride, letter);
}

std::string sub_text(const Entry& entry) {
  return entry.sub == entry.last_sub ? fmt::format("{}", entry.sub)
                                     : fmt::format("{}..{}", entry.sub, entry.last_sub);
}

}  // namespace

std::string object_table() {
  std::string text =
      "# The object dictionary\n\n"
      "Printed by `plenum_dictionary --table` from the table in `dictionary/`: do not edit. c = 0..7 is the "
      "chamber less one, "
      "n the PDO\nless one; \"kept\" is what 1010h stores.\n\n"
      "| index | sub | name | type | access | PDO | range | kept |\n|---|---|---|---|---|---|---|---|\n";
  for (const Entry& entry : canopen::object_dictionary()) {
    const std::string name =
        entry.object_name != nullptr ? fmt::format("**{}**: {}", entry.object_name, entry.name) : entry.name;
    const std::string range =
        entry.range.limited ? fmt::format("{} .. {}", entry.range.low, entry.range.high) : "";
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} |\n", index_text(entry), sub_text(entry),
                        name, type_name(entry.type), access_name(entry.access), mappable_name(entry.mappable),
                        range, entry.kept == canopen::Kept::no ? "" : "kept");
  }
  return text;
}

}  // namespace plenum::host::dictionary
