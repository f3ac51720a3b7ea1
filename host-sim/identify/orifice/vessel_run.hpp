// The pressure of a vessel behind one orifice, in free run.
//
//   pdot = +-k p_u psi_e(p_d / p_u) / psi_max                                 vessel.hpp; (4), (6), (7)
//
// The port is a plant::EllipsePort whose choked flow is the choked rate k [1/s]: its flow is pdot [Pa/s]. The
// far pressure is the record's, its mean over each step.
//
// Numerical treatment: each step is solved in closed form after linearising pdot at its middle p_m,
//   p+ = p + h phi_1(h J) (F + J (p - p_m)),  phi_1(z) = (e^z - 1)/z,  F and J = d pdot / d p at p_m
// exact while choked, second order else, and free of a stability limit near the cracking ratio, where J is
// large. There the flow shuts with a corner: a middle beyond it is moved back to it, from where J leads the
// step to rest, and no step ends beyond. A row is divided so that the record's ratio moves by less than 0.01
// in a step: the division depends on the record and not on the parameters, and the run stays smooth in them.
// Source: "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve Model",
// Validation, whose fourth-order Runge-Kutta needs short steps where the flow shuts.
#pragma once

#include <vector>

#include "host-sim/identify/orifice/vessel.hpp"
#include "host-sim/plant/orifice.hpp"

namespace plenum::host::identify::orifice {

/// pdot [Pa/s] and its slope [1/s] at one vessel and one far pressure [Pa].
struct Rate {
  double rate_Pa_s;
  double slope_1_s;
};
Rate vessel_rate(const plant::EllipsePort& port_1_s, Flow flow, double vessel_Pa, double far_Pa);

/// The vessel's pressure [Pa] at the record's times, from `start_Pa` at its first row. Of the record's own
/// vessel pressure only the division into steps is taken. Throws as validate().
std::vector<double> free_run(const plant::EllipsePort& port_1_s, const VesselRecord& record, double start_Pa);

/// (9), of n values: 1/n sum |f_i - y_i| [unit of the values]. Throws std::invalid_argument unless of equal
/// length, one or more.
double mean_absolute_error(const std::vector<double>& predicted, const std::vector<double>& recorded);

}  // namespace plenum::host::identify::orifice
