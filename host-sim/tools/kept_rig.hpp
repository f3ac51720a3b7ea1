// The rig that a simulated board belongs to, in its store beside the board's own slots: settings fit no other.
#pragma once

#include <filesystem>

#include "host-sim/tools/command_line.hpp"
#include "host-sim/tools/inproc.hpp"

namespace plenum::host::tools {

/// Of what the store keeps, takes what `given` leaves out: all but the seed, which is each run's own. Without such a store, or
/// in one of before, `rig` stays. Throws std::invalid_argument where the two differ, InputError for files that cannot be read.
void take_rig(RigChoice& rig, const Arguments& given, const std::filesystem::path& store);

/// Makes it the store's. Throws InputError, also where the store has another one.
void keep_rig(const RigChoice& rig, const std::filesystem::path& store);

}  // namespace plenum::host::tools
