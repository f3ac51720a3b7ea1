// The rig as a diagnosis has found it.
#pragma once

#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::diagnose {

/// The effects that go into one model together, in order of their share: of those that the log cannot tell apart
/// only the first.
std::vector<NamedEffect> effects_in_model(const GapReport& report);

/// `rig` with its valve as fitted and the effects found, to six digits: what `sim`, `identify` and `diagnose` accept.
trace::RigDescription found_rig(trace::RigDescription rig, const GapReport& report);

}  // namespace plenum::host::diagnose
