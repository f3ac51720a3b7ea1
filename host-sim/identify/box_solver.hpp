// Levenberg-Marquardt within a box, on the Gram matrix of the Jacobian and the errors.
//
//   each iteration minimises  f + g.d + d.(H + lambda D) d/2  over  low <= z + d <= high,  H = J^T J, g = J^T
//   e, D = diag H exactly, by a primal active-set method on n <= 9 unknowns; lambda by the gain ratio
//   (Nielsen 1999); D never shrinks (More 1978).
//
// Each step is also held within one unit of every variable: the variables are scaled to be of order one, and
// further than that the model is not near its linearisation (without it some starts run to a rate of zero,
// where nothing changes any more). Near the minimum the curvature that Gauss-Newton leaves out is learnt by
// secant updates.
//
// Why not a library's solver: with H known (the rows are summed up before), the bounded quadratic costs
// microseconds, and a parameter at its bound stays there while the others converge as fast as without bounds.
// Ceres 2.1 on the same compressed problem (ten residuals of equal cost and gradient) steps first and
// projects afterwards: 54 to 65 iterations and 48 to 122 ms from the default start on three chambers on which
// an early form of this one, in better scaled variables, needed 28 to 36 and 9 to 16 ms. The tests hold this
// solver against Ceres with automatic derivatives.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

#include "host-sim/identify/squares.hpp"

namespace plenum::host::identify {

using Vector9 = Eigen::Matrix<double, kFree, 1>;

/// A sum of squares of 9 variables. A variable whose low and high are equal is held.
struct BoxProblem {
  std::function<double(const Vector9&)> squares;  ///< sum of squared errors
  std::function<Gram(const Vector9&)> gram;       ///< Gram matrix of [J e] by the variables
  Vector9 low;
  Vector9 high;
};

struct BoxSolution {
  Vector9 z = Vector9::Zero();
  double squares = 0.0;
  int iterations = 0;  ///< evaluations of the Gram matrix and trial steps that were refused
  bool converged = false;
  std::string stop;  ///< why it stopped, in one line
};

/// From `start`, which must lie within the box. Stops when the model promises less than
/// `tolerance` of the sum of squares, or a step of less than 1e-9.
BoxSolution minimise_in_box(const BoxProblem& problem, const Vector9& start, int most_iterations,
                            double tolerance);

/// argmin of g.d + d.H d/2 over low <= d <= high for positive definite H; 0 must lie within.
Vector9 quadratic_in_box(const Eigen::Matrix<double, kFree, kFree>& H, const Vector9& g, const Vector9& low,
                         const Vector9& high);

}  // namespace plenum::host::identify
