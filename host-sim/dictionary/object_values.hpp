// Values of the object dictionary, outside a board.
#pragma once

#include <compare>
#include <cstdint>
#include <map>

namespace plenum::host::dictionary {

struct ObjectId {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  // NOLINTNEXTLINE(modernize-use-nullptr): what the compiler makes of it compares with 0
  friend auto operator<=>(const ObjectId&, const ObjectId&) = default;
};

/// The bits of each, as an SDO of one to four bytes carries them.
using ObjectValues = std::map<ObjectId, std::uint32_t>;

/// What a board of this node id (1..127) is delivered with of all that 1010h stores.
ObjectValues delivered_values(std::uint8_t node_id);

}  // namespace plenum::host::dictionary
