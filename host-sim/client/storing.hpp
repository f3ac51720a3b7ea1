// Whether a board has stored what it was told.
#pragma once

#include "host-sim/client/session.hpp"

namespace plenum::host::client {

/// Waits until the set in force is the stored one (2130h). Throws Refused when the board cannot store it, Timeout.
void await_stored(Session& session, double timeout_s = 5.0);

}  // namespace plenum::host::client
