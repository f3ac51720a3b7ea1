#include "host-sim/dictionary/object_values.hpp"

#include <memory>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/dictionary/data_sheet.hpp"

namespace plenum::host::dictionary {

ObjectValues delivered_values(std::uint8_t node_id) {
  const auto sheet = std::make_unique<DataSheet>(canopen::Identity{});
  ObjectValues values;
  for (const canopen::Entry& entry : canopen::object_dictionary()) {
    if (entry.kept == canopen::Kept::no) continue;
    for (unsigned instance = 0; instance < entry.instances; ++instance) {
      for (unsigned sub = entry.sub; sub <= entry.last_sub; ++sub) {
        const canopen::Place place{static_cast<std::uint8_t>(instance), static_cast<std::uint8_t>(sub)};
        std::uint32_t bits = 0;
        static_cast<void>(entry.read_value(sheet->sheet.delivered(), place, bits));  // kept: never refused
        if (canopen::adds_node_id(entry, bits)) bits += node_id;
        values[{static_cast<std::uint16_t>(entry.index + instance * entry.stride), place.sub}] = bits;
      }
    }
  }
  return values;
}

}  // namespace plenum::host::dictionary
