// The words for emergency codes: the board's own, and the classes of CiA 301 (table 26).
#pragma once

#include <cstdint>

namespace plenum::host::client {

/// Never null; the words of its class for a code that the board does not raise.
const char* emergency_text(std::uint16_t code);

}  // namespace plenum::host::client
