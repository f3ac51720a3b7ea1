// What a transfer is about, in words.
#pragma once

#include <string>

#include "host-sim/client/session.hpp"

namespace plenum::host::client {

/// "chamber 3: Active model image, 84 of 144 bytes"; an object of the board by its name alone, one that the dictionary lacks as "1F50h:1".
std::string text_of(const Transfer& transfer);

}  // namespace plenum::host::client
