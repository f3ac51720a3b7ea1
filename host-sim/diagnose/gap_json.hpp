// A gap report as JSON of schema plenum-gap/1, a contract: README.md here.
#pragma once

#include <nlohmann/json.hpp>

#include "host-sim/diagnose/gap_report.hpp"

namespace plenum::host::diagnose {

/// The report without its traces and its map, in the key order of the contract; what is added to it comes
/// last in each object: "share", "at_bound", "parameters" of a candidate, "gap_p_value", "calibration",
/// "detectable", "alias_classes", "stamped_early_s". Gaps in kPa. Numbers are rounded to five significant digits; one that is
/// not finite, such as the end of an interval that the log leaves open, is null.
nlohmann::ordered_json to_json(const GapReport& report);

}  // namespace plenum::host::diagnose
