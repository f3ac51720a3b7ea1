// The page of the demonstration.
#pragma once

#include "host-sim/report/page.hpp"
#include "host-sim/tools/demo.hpp"

namespace plenum::host::tools {

report::Page demo_page(const Demo& demo);

/// RMS over all references that have no steps, of all chambers [kPa]: steps are beyond any valve.
double smooth_rmse_kPa(const Demo& demo);
/// Largest of Drift::worst_std_percent.
double worst_drift_percent(const Demo& demo);

}  // namespace plenum::host::tools
