// The two-stage valve at rest.
//
// With x' = y' = 0 the flows and force balances of two_stage.hpp are a set of implicit equations; the source
// iterates on y. Here x is given: then one equation in y is left that rises with it,
//   (A1 - F/P1)(P2(y) + Q_pilot(y)/c_cap) - A2 P2(y) = K_m (x + x0),   P2(y) from the pilot's balance,
// and Q rises with x. Range: the flow force does not outweigh A_p on the way (y is sought below that).
// Source: "Grey-Box Multi-Port Models of Fluid Power Valves", appendix A, steady-state analysis.
#pragma once

#include <vector>

#include "host-sim/plant/relief_valve/two_stage.hpp"

namespace plenum::host::plant::relief_valve {

/// P2 [Pa] at which the pilot begins to open, K_p y0 / A_p; below it nothing flows.
double pilot_cracking_Pa(const TwoStageConfig& config);

/// The state at rest that passes `flow_m3_s`. Throws std::invalid_argument unless the flow is at least what
/// opens the main spool and at most what its travel lets pass.
TwoStageState two_stage_at_rest(const TwoStagePhysics& physics, double flow_m3_s);

/// Flow through the pilot alone at which the main spool begins to open [m3/s].
double least_main_flow_m3_s(const TwoStagePhysics& physics);

/// One mode of the valve linearised at rest.
struct Mode {
  double growth_1_s = 0.0;    ///< real part of the eigenvalue: below 0 it dies away
  double frequency_Hz = 0.0;  ///< imaginary part / 2 pi, >= 0
};
/// The six eigenvalues about a state, pairs once, by falling growth.
std::vector<Mode> modes(const TwoStagePhysics& physics, const TwoStageState& state);

}  // namespace plenum::host::plant::relief_valve
