// The object dictionary as a table for people.
#pragma once

#include <string>

namespace plenum::host::dictionary {

/// firmware/canopen/OBJECTS.md: Markdown, one line a row of the dictionary.
std::string object_table();

}  // namespace plenum::host::dictionary
