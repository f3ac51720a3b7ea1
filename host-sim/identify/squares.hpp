// Sums of squares of the two prediction errors, with everything that Gauss-Newton needs of them.
//
//   one step   e_i = y_(i+1) predicted from y_i - y_(i+1), as the paper's section V.C, averaging taken into
//   account free run   e_i = y_(i+1) predicted from the start of a stretch of a few seconds - y_(i+1); each
//   stretch has its own
//              initial pressure p0, in which the prediction is linear: it is eliminated exactly (variable
//              projection, Golub and Pereyra 1973, with Kaufman's 1975 Jacobian)
//
// A sum over N rows with Jacobian J [N x 9] enters a solver only through the Gram matrix of [J e] [10 x 10],
// which is summed up row block by row block: J is never stored.
//
// The shape parameters q (below) are c with the volume taken at its mean V, because (c5, c6, c7) in (10e) lie
// in a long valley: only their ratio is seen where c6 v >> 1, and physics (rate inverse to volume) puts the
// truth at its far end.
//   r = (e7 k + e5 v')/(1 + d (v/V - 1)),  d = c6 V/(1 + c6 V) in [0, 1),  e5 = c5/(1 + c6 V),  e7 = c7/(1 +
//   c6 V)
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "host-sim/identify/tassa9.hpp"
#include "host-sim/identify/ticks.hpp"

namespace plenum::host::identify {

/// c1, c2, c3, c4, e5 [1/mL], d [1], e7 [1/(V s)], c8, c9 in this order.
using Shape = Eigen::Matrix<double, kFree, 1>;
using Gram = Eigen::Matrix<double, kFree + 1, kFree + 1>;

/// What stays the same during one fit.
struct Bench {
  const Ticks* ticks = nullptr;
  double mean_volume_mL = 1.0;  ///< V
  double c_gamma_V = 0.1;
  double supply_kPa = 0.0;
  double ambient_kPa = 0.0;
  Form form = Form::published;
  std::size_t stretch = 200;  ///< ticks of a free run
  std::size_t every = 1;      ///< one-step errors of every n-th block of ticks only: a cheap look
};

Shape to_shape(const Tassa9& model, double mean_volume_mL);
Tassa9 to_model(const Shape& shape, const Bench& bench);

/// d(c1..c9)/d(shape).
Eigen::Matrix<double, kFree, kFree> model_by_shape(const Shape& shape, double mean_volume_mL);

enum class Error { one_step, free_run };

/// Number of rows that enter the sum, and of initial pressures eliminated from it.
struct Count {
  std::size_t rows = 0;
  std::size_t eliminated = 0;
};
Count count_rows(Error error, const Bench& bench);

/// Sum of squared errors [kPa^2].
double sum_of_squares(Error error, const Shape& shape, const Bench& bench);

/// Gram matrix of [J e], J by shape: its last diagonal element is sum_of_squares.
Gram gram(Error error, const Shape& shape, const Bench& bench);

}  // namespace plenum::host::identify
