// The default PDOs of a board as a DBC file, the format of bus monitors.
#pragma once

#include <cstdint>
#include <string>

namespace plenum::host::dictionary {

/// Messages and signals of the PDOs that are switched on by default, for a board of this node id (1..127). Signal names
/// and ranges are the table's; units are those of the records (mbar), or stand in brackets in the object's name.
std::string dbc(std::uint8_t node_id);

}  // namespace plenum::host::dictionary
