// The valve as three conditions: rising, falling, and the pressure at rest within the dead band.
//
//   a positive turn of the screw beyond the dead band   (30) about the means of the rising branch
//   a negative turn of the screw beyond the dead band   (31) about the means of the falling branch
//   else                                                the pressure stays                    (V section 4)
//
// The dead band is where the screw may turn without either: it lies below the highest position of a rise and
// above the lowest of a fall, and is pushed along by the screw. A condition holds until the screw has turned
// away from its edge, also while the screw rests. On a change of condition the past is the pressure that stayed.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods", section 4.
#pragma once

#include <vector>

#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/discrete_model.hpp"

namespace plenum::host::identify::regulator_valve {

/// A model and the point about which its deviations count.
struct CenteredModel {
  DiscreteModel model;
  double mean_screw_m = 0.0;
  double mean_pressure_Pa = 0.0;
};

struct PiecewiseModel {
  CenteredModel rising;
  CenteredModel falling;
  double dead_band_m = 0.0;
};

/// Pressures [Pa, gauge] over `screw_m`, from `start_Pa` with the screw at the upper edge of the dead band (a
/// rise is about to begin). Throws std::invalid_argument for a dead band below 0.
std::vector<double> predict(const PiecewiseModel& model, const std::vector<double>& screw_m, double start_Pa);

}  // namespace plenum::host::identify::regulator_valve
