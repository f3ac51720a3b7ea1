// `plenum sim --bus`: a rig in real time, on a bus that other programs can join.
#pragma once

#include <optional>

#include "host-sim/client/bus_address.hpp"
#include "host-sim/rig/rig.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {

struct ServeOptions {
  std::optional<double> seconds;  ///< of the rig's time; none: until SIGINT or SIGTERM
  double speed = 1.0;             ///< seconds of the rig in one of the clock
};

/// Serves until the time is over or somebody asks to stop. Prints a line when clients may come, and what the bus carried
/// at the end. Each tick has its absolute deadline: after a delay the rig catches up. Throws std::runtime_error when the
/// address cannot be served.
int serve(const rig::RigConfig& config, const client::SocketcandAddress& address, const ServeOptions& options,
          const Output& output);

}  // namespace plenum::host::tools
