// The PDOs of a board as a DBC file, the format of bus monitors.
#pragma once

#include <cstdint>
#include <string>

#include "host-sim/dictionary/object_values.hpp"

namespace plenum::host::dictionary {

/// Messages and signals of the PDOs that are switched on, for a board of this node id (1..127). `values`: its PDO parameters
/// 1400h to 1BFFh as SDO reads them, and 2228h:2; what is left out is switched off, or as delivered. Signal names and
/// ranges are the table's; units are those of the records (mbar), or stand in brackets in the object's name. Throws
/// std::invalid_argument for a mapping that no board has.
std::string dbc(std::uint8_t node_id, const ObjectValues& values);

}  // namespace plenum::host::dictionary
