// What the fit of the nine parameters holds, found by trying: the kink width c_gamma of (9), and the valve's dead time.
//
// The paper fixes c_gamma at 0.1 V, which suits valves whose two ports open within a fraction of a volt. A
// valve with a dead band has a wider kink: the measured MPYE tables do, over more than a volt, and a fit at
// 0.1 V is far off there.
//
// The paper's model has no dead time, its valve a spool that answers within a tick. Whatever delays the pressure by more, be it a
// slow spool, a hose or a filter in the sensor, is a dead time to it; a regulator that knows nothing of one of 25 ms oscillates.
#pragma once

#include <array>
#include <vector>

#include "host-sim/identify/fit.hpp"

namespace plenum::host::identify {

/// [V]; the first is the paper's.
inline constexpr std::array<double, 5> kKinkWidths_V{0.1, 0.2, 0.4, 0.8, 1.6};

/// What is tried; the other of the two is that of the options.
struct Profiled {
  bool kink_width = true;
  bool dead_time = true;
};

/// The dead time is that of the smallest error of the next tick, first among whole ticks up to trace::kLongestDeadTime_s, at last to a
/// fiftieth of one: that error shows it best. (By free runs of 0.2 s it comes out 3 ms too long on thin-plate valves, for what the form
/// misses.) What the logs tell of the other parameters has no part in the choice; where they cannot be fitted at the dead time chosen,
/// that is said. A tick of it has to be worth the variance of an error: where the logs tell none it is 0, with a standard error that
/// says how little they tell. It is `identifiable` when that is below a quarter of a tick, and at its upper bound when the logs would
/// have it longer.
///
/// Where the volume moves the published form's is that of the repaired one, if that has the smaller error: it is the valve's, and not
/// what a form misses.
///
/// The width is that of the smallest free-run error over stretches of `options.stretch_s`; one without a fit is passed over.
/// Throws CannotIdentify when none is left, with the reason given at the first.
Tassa9Fit fit_tassa9_profiled(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                              const FitOptions& options = {}, const Profiled& profiled = {});

}  // namespace plenum::host::identify
