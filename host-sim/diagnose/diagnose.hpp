// The diagnosis of the gap between a simulated chamber and the measured one.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::diagnose {

using trace::NamedLog;

struct DiagnoseOptions {
  std::function<void(double share)> progress;
  std::vector<std::string> strike;  ///< effects left out of the catalogue
  unsigned threads = 2;
};

/// Finds the gap between the rig's nominal model and the logs of one chamber, where it lies, which effects cause it and
/// how far they close it. Without `heldout` the last 40 % of each log are held out. Throws std::invalid_argument for
/// an unknown effect in `strike` and for more than 16 logs of either kind; logs that cannot be diagnosed are for require_diagnosable() to refuse.
GapReport diagnose(const std::vector<NamedLog>& logs, const std::vector<NamedLog>& heldout,
                   const trace::RigDescription& rig, const DiagnoseOptions& options = {});

}  // namespace plenum::host::diagnose
