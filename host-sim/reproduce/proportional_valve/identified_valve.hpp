// The paper's procedure on the simulated rig: every set point of every series measured and fitted, by the
// paper's rate fit and by the pressure fit; and its validation model, look-up tables under a fourth-order
// Runge-Kutta.
#pragma once

#include <functional>
#include <vector>

#include "host-sim/identify/orifice/fit_orifice.hpp"
#include "host-sim/reproduce/proportional_valve/experiment.hpp"

namespace plenum::host::reproduce::proportional_valve {

/// A set point, measured and fitted.
struct IdentifiedRow {
  Row row;
  identify::orifice::OrificeFit rate_fit;      ///< the paper's method
  identify::orifice::OrificeFit pressure_fit;  ///< ours
  double rate_fit_mae_kPa = 0.0;  ///< (9), free run from the first pressure of its 1 kHz record, against it
  double pressure_fit_mae_kPa = 0.0;
};

struct IdentifiedSeries {
  Series series;
  std::vector<IdentifiedRow> rows;
};

/// One series at all its set points; `row_done` after each.
IdentifiedSeries identify_series(
    const Series& series, const RigOptions& options, const std::function<void()>& row_done = [] {});

/// Pressure fit of a record of any length: blocks of samples keep it near a thousand rows.
identify::orifice::OrificeFit fit_pressures(const identify::orifice::VesselRecord& record,
                                            const identify::orifice::Vessel& vessel);

/// The validation model (Fig. 7): tables of both directions of one channel by the rate fit, interpolated
/// linearly in the command; where a table has no area it keeps the flow shape of its last row. Runge-Kutta at
/// the sampling time.
std::vector<double> simulate_sine(const IdentifiedSeries& charge, const IdentifiedSeries& discharge,
                                  const SineExperiment& experiment);

}  // namespace plenum::host::reproduce::proportional_valve
