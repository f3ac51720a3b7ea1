// Levenberg-Marquardt within a box, on the Gram matrix of the Jacobian and the errors.
//
//   each iteration minimises  f + g.d + d.(H + lambda D) d/2  over  low <= z + d <= high,  H = J^T J, g = J^T
//   e, D = diag H exactly, by a primal active-set method on n unknowns; lambda by the gain ratio
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

/// Most variables of a problem whose size is known only at run time.
inline constexpr int kMostVariables = 116;

/// Vectors and matrices of a problem of `kSize` variables; Eigen::Dynamic: up to kMostVariables. They never allocate.
template <int kSize>
using BoxVector = Eigen::Matrix<double, kSize, 1, 0, (kSize > 0 ? kSize : kMostVariables), 1>;
template <int kSize, int kMost = (kSize > 0 ? kSize : kMostVariables)>
using BoxMatrix = Eigen::Matrix<double, kSize, kSize, 0, kMost, kMost>;
/// Of [J e]: one larger than the matrix.
template <int kSize>
using BoxGram = BoxMatrix<(kSize > 0 ? kSize + 1 : Eigen::Dynamic), (kSize > 0 ? kSize : kMostVariables) + 1>;

/// A sum of squares. A variable whose low and high are equal is held.
template <int kSize>
struct BoxProblem {
  std::function<double(const BoxVector<kSize>&)> squares;       ///< sum of squared errors
  std::function<BoxGram<kSize>(const BoxVector<kSize>&)> gram;  ///< Gram matrix of [J e] by the variables
  BoxVector<kSize> low;
  BoxVector<kSize> high;
};

template <int kSize>
struct BoxSolution {
  BoxVector<kSize> z;
  double squares = 0.0;
  BoxGram<kSize> gram;  ///< at z
  int iterations = 0;   ///< evaluations of the Gram matrix and trial steps that were refused
  bool converged = false;
  std::string stop;  ///< why it stopped, in one line
};

/// From `start`, which must lie within the box. Stops when the model promises less than
/// `tolerance` of the sum of squares, or a step of less than 1e-9. For kFree variables and for Eigen::Dynamic.
template <int kSize>
BoxSolution<kSize> minimise_in_box(const BoxProblem<kSize>& problem, const BoxVector<kSize>& start,
                                   int most_iterations, double tolerance);

/// argmin of g.d + d.H d/2 over low <= d <= high for positive definite H; 0 must lie within.
template <int kSize>
BoxVector<kSize> quadratic_in_box(const BoxMatrix<kSize>& H, const BoxVector<kSize>& g,
                                  const BoxVector<kSize>& low, const BoxVector<kSize>& high);

using Vector9 = BoxVector<static_cast<int>(kFree)>;

}  // namespace plenum::host::identify
