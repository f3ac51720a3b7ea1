// The words of CiA 301 for its SDO abort codes (table 22).
#pragma once

#include <cstdint>

namespace plenum::host::client {

/// Never null; "unknown abort code" for a code that CiA 301 does not name.
const char* abort_text(std::uint32_t code);

}  // namespace plenum::host::client
