// A sum of squares of a few variables within bounds, by the trust-region Levenberg-Marquardt of
// box_solver.hpp, and what the minimum says about each variable.
//
// Ceres, which steps first and projects onto the bounds afterwards, ends no lower (a test holds this to it) and
// took 60 to 150 iterations on those rows of the MPYE whose b or beta is at a bound, where this takes 5 to 20.
//
// The Jacobian is by central differences, because the errors are runs of an integrator whose step division
// does not depend on the variables. The covariance is (J^T J)^-1 s^2 of the variables that are neither held
// nor at a bound, by eigenvalues of the columns scaled to unit length: a direction that the errors do not see
// (eigenvalue below 1e-13 of the greatest) gives its variables an infinite variance rather than a wrong one.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host-sim/identify/estimate.hpp"

namespace plenum::host::identify::orifice {

struct BoundedSquares {
  int rows = 0;                                                     ///< errors
  std::function<void(const double* variables, double* errors)> at;  ///< writes `rows` errors
  std::vector<double> low;
  std::vector<double> high;  ///< equal to low: the variable is held
  std::vector<double> step;  ///< of the central differences
};

struct SquaresMinimum {
  std::vector<double> variables;
  std::vector<Bound> at_bound;          ///< none for held variables
  std::vector<double> standard_errors;  ///< 0 where held, NaN at a bound, infinite where undetermined
  double squares = 0.0;
  int iterations = 0;
  bool converged = false;
  std::string stop;  ///< why it stopped, in one line
};

/// From `start`, moved inside the bounds. Stops when the model promises less than `tolerance` of the sum of
/// squares.
SquaresMinimum minimise(const BoundedSquares& problem, std::vector<double> start, double tolerance,
                        int most_iterations = 200);

}  // namespace plenum::host::identify::orifice
