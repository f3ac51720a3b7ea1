// The kink width c_gamma of (9), which the fit holds, found by trying.
//
// The paper fixes c_gamma at 0.1 V, which suits valves whose two ports open within a fraction of a volt. A
// valve with a dead band has a wider kink: the measured MPYE tables do, over more than a volt, and a fit at
// 0.1 V is far off there.
#pragma once

#include <array>
#include <vector>

#include "host-sim/identify/fit.hpp"

namespace plenum::host::identify {

/// [V]; the first is the paper's.
inline constexpr std::array<double, 5> kKinkWidths_V{0.1, 0.2, 0.4, 0.8, 1.6};

/// fit_tassa9() at each of kKinkWidths_V; keeps the fit whose free-run error over stretches of
/// `options.stretch_s` is smallest. `options.c_gamma_V` is not used. Widths at which there is no fit are
/// passed over; throws CannotIdentify when none is left, with the reason given at the paper's width.
Tassa9Fit fit_tassa9_profiled(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                              const FitOptions& options = {});

}  // namespace plenum::host::identify
