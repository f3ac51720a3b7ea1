// The third-order model whose free run fits best, found by particle swarm.
//
//   least over b, a_1, a_2, a_3 of |y^ - y|^2, y^ the free run: the model of the greatest fit (39)
//
// The paper does not say what its swarm minimises nor where it looks. The free run is what its Table 4 scores.
// Slow stable models are a thin sheet in (b, a_1, a_2, a_3): 1 + a_1 + a_2 + a_3 is 1e-3 between numbers of order
// one, and a swarm does not find along a sheet oblique to its axes. It searches
//   gain = b / residue [Pa/m], residue = 1 + a_1 + a_2 + a_3, a_1, a_2
// instead, in a box that holds every model that settles, slower than 14 ms; the gain between 0.3 and 3 times the
// ratio of the recorded spans. Nothing of the least squares is used.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods", (35)-(37), section 4.2.
#pragma once

#include <functional>

#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/discrete_model.hpp"
#include "host-sim/identify/swarm/swarm.hpp"

namespace plenum::host::identify::regulator_valve {

struct SwarmFit {
  DiscreteModel model;
  swarm::Solution search;  ///< of gain [Pa/m], residue, a_1, a_2; cost |y^ - y|^2 [Pa^2]
};

/// Throws CannotIdentify for fewer than 8 samples, where screw or pressure never change, and where the gain or
/// the residue ends at its bound; std::invalid_argument as swarm::minimise().
SwarmFit fit_swarm(const Branch& branch, const swarm::Settings& settings = {},
                   const std::function<void(double)>& progress = {});

}  // namespace plenum::host::identify::regulator_valve
