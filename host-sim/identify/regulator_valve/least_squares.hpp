// One-step least squares: Theta = [Psi^T Psi]^-1 Psi^T Y                                              (V (33))
//
//   rows of Psi: -p(k-1), -p(k-2), -p(k-3), x_p(k-1); of Y: p(k); Theta = a_1, a_2, a_3, b
//
// By a pivoted QR of Psi, which is (33) without squaring its condition. What is fitted is the next sample from
// three measured ones: noise in those regressors pulls a_1, a_2, a_3 towards the average of the three, however
// many rows there are. The static gain hardly suffers, the poles do.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods".
#pragma once

#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/discrete_model.hpp"

namespace plenum::host::identify::regulator_valve {

/// Throws CannotIdentify for fewer than 8 samples, and where the columns of Psi depend on each other: no
/// excitation.
DiscreteModel fit_least_squares(const Branch& branch);

}  // namespace plenum::host::identify::regulator_valve
