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

/// Of the rows of each log, where none is held out: the others are.
inline constexpr double kFittedShare = 0.6;

struct DiagnoseOptions {
  std::function<void(double share)> progress;
  std::vector<std::string> strike;  ///< effects left out of the catalogue
  unsigned threads = 2;
  std::vector<NamedLog> baseline{};  ///< of the machine as it was: what has changed since is then asked
};

/// Finds the gap between the rig's nominal model and the logs of one chamber, where it lies, which effects cause it and
/// how far they close it. With a baseline it diagnoses that first, takes its rig as found, and then asks what has changed
/// since: the valve's figures answer for both, an effect for the later logs only, and the floor is what the model leaves of
/// the baseline; the other hypothesis is that the valve alone has changed. Without `heldout` the last 40 % of each log are held out. Throws std::invalid_argument for
/// an unknown effect in `strike` and for more than 16 logs, baselines among them, or held-out logs; logs that cannot be diagnosed are for require_diagnosable() to refuse.
GapReport diagnose(const std::vector<NamedLog>& logs, const std::vector<NamedLog>& heldout,
                   const trace::RigDescription& rig, const DiagnoseOptions& options = {});

}  // namespace plenum::host::diagnose
