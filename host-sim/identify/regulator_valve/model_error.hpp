// How well a branch knows the model that was fitted to it.
//
//   covariance of Theta = a_1, a_2, a_3, b:  s^2 (J^T J)^-1,  s^2 = |e|^2 / (rows - 4)
//   one step, V (33)      e(k) = p(k) - p(k | measured past),  J(k) = [-p(k-1) -p(k-2) -p(k-3) x_p(k-1)]
//   free run              e(k) = p(k) - p^(k),  J(k) = dp^(k)/dTheta, (30) differentiated:
//     dp^(k) = [-p^(k-1) -p^(k-2) -p^(k-3) x_p(k-1)] - a_1 dp^(k-1) - a_2 dp^(k-2) - a_3 dp^(k-3)
//
// Errors count as white and without bias: that of the one step, which noise in its regressors causes, is not in it, and
// where the model does not hold these are lower bounds. What follows from Theta (static gain, time constant, internal
// parameters) has the error of its first derivatives, taken by central differences.
// Numerical treatment: columns scaled to unit length, pivoted QR; a direction that the branch does not see makes the
// covariance infinite.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods", (30), (33).
#pragma once

#include <Eigen/Core>

#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/discrete_model.hpp"
#include "host-sim/identify/regulator_valve/internal_parameters.hpp"

namespace plenum::host::identify::regulator_valve {

/// Standard errors of one model.
struct ModelError {
  Eigen::Matrix4d covariance;  ///< of a_1, a_2, a_3 [-], b [Pa/m]
  double static_gain_Pa_m = 0.0;
  double slowest_time_constant_s = 0.0;  ///< infinite of a model that is not stable

  double coefficient(Eigen::Index i) const;  ///< 0 .. 3: a_1, a_2, a_3, b
};

/// Throws std::invalid_argument as validate(branch), and for fewer than 8 samples.
ModelError one_step_error(const DiscreteModel& model, const Branch& branch);
ModelError free_run_error(const DiscreteModel& model, const Branch& branch);

/// Standard errors of internal_parameters(), field by field. Throws as it does.
InternalParameters internal_parameter_errors(const DiscreteModel& rising, const ModelError& rising_error,
                                             const DiscreteModel& falling, const ModelError& falling_error,
                                             const SystemConstants& constants = {});

}  // namespace plenum::host::identify::regulator_valve
