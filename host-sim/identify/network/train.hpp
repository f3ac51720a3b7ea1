// Training of a network by Levenberg-Marquardt.
//
//   V_N(theta) = 1/(2N) sum_t [y(t) - yhat(t | theta)]^2                                                 (29)
//   theta(i+1) = theta(i) + f(i),   [R(theta(i)) + lambda(i) I] f(i) = -G(theta(i))                      (30)
//   G = -1/N sum_t psi(t) eps(t),   R = 1/N sum_t psi(t) psi(t)^T,   psi = d yhat / d theta
//
// y wanted output, eps = y - yhat, G gradient and R Gauss-Newton's Hessian of V_N, lambda damping. (30) is
// printed without its right-hand side; -G is what makes f a descent.
//
// lambda follows the gain ratio, the fall of V_N against that of its quadratic model: halved above 0.75,
// doubled below 0.25; a step that does not lower V_N is refused. Stops when the gradient, or the fall of V_N
// in ten steps, is below the tolerance, or when no damping finds a descent. The same data, start and options
// give the same bits.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (29), (30).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

#include "host-sim/identify/network/network.hpp"

namespace plenum::host::identify::network {

/// One case a row.
struct Cases {
  Eigen::MatrixXd inputs;   ///< phi [N x network inputs]
  Eigen::VectorXd outputs;  ///< y [N]
};

struct TrainingOptions {
  int most_iterations = 200;
  double first_damping = 1.0;         ///< lambda(0)
  double gradient_tolerance = 1e-12;  ///< of the largest |G|
  double fall_tolerance = 1e-7;       ///< of V_N, in ten steps
};

struct Training {
  Network network;
  double criterion = 0.0;  ///< V_N reached
  int iterations = 0;      ///< steps tried, refused ones included
  std::string stop;        ///< why it stopped, in one line
};

/// (29)
double criterion(const Network& network, const Cases& cases);

/// G of (30): the derivative of V_N by the weights.
Eigen::VectorXd criterion_gradient(const Network& network, const Cases& cases);

/// From the weights of `start`; `progress` is told the share of most_iterations done. Throws
/// std::invalid_argument when shapes differ or a value is not finite, CannotIdentify when there are fewer
/// cases than weights.
Training train(const Network& start, const Cases& cases, const TrainingOptions& options = {},
               const std::function<void(double)>& progress = {});

}  // namespace plenum::host::identify::network
