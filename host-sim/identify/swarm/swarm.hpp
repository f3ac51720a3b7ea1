// Particle swarm optimisation with constriction: the least of any cost within a box, without derivatives.
//
//   v_i <- chi [v_i + phi_1 U_1 * (p_i - x_i) + phi_2 U_2 * (s - x_i)]                               (V (35))
//   x_i <- x_i + v_i                                                                                 (V (36))
//   chi = 2 k / |2 - phi - sqrt(phi^2 - 4 phi)|,  phi = phi_1 + phi_2                                (V (37))
//
// x_i position and v_i speed of particle i, in the units of the variables; p_i the best place it has found, s
// the best of all; U_1, U_2 uniform in [0, 1), drawn anew for every component; * by components.
//
// What the paper leaves open: particles start anywhere in the box, at rest. One that would leave the box stops
// on its face, its speed there becomes 0. s is renewed once all have moved. A cost that is not a number, or not
// finite, is worse than any that is.
// The swarm knows no gradient: on smooth sums of squares Gauss-Newton takes a thousandth of its evaluations. It
// earns them where the cost has many minima or none but its value.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods", after Clerc and Kennedy (2002).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

namespace plenum::host::identify::swarm {

/// (37). 1 at phi = 4 and k = 1, then falling. Throws std::invalid_argument for phi < 4, where the root is not
/// real, and for k outside (0, 1].
double constriction_factor(double phi, double k = 1.0);

struct Settings {
  int particles = 40;
  int iterations = 300;
  double cognitive = 2.05;  ///< phi_1
  double social = 2.05;     ///< phi_2
  double k = 1.0;           ///< of (37)
  std::uint64_t seed = 1;   ///< the same seed is the same search, bit by bit
};

struct Box {
  Eigen::VectorXd low;
  Eigen::VectorXd high;
};

struct Solution {
  Eigen::VectorXd best;             ///< s
  double cost = 0.0;                ///< there
  std::vector<double> best_so_far;  ///< cost at s, at the start and after each iteration; never rises
};

using Cost = std::function<double(const Eigen::VectorXd&)>;

/// particles * (iterations + 1) evaluations of `cost`, each within the box; `progress` is told the share done. Throws std::invalid_argument for a
/// box that is empty, upside down or not finite, for less than one particle or iteration, and as
/// constriction_factor(); CannotIdentify if the cost was finite nowhere.
Solution minimise(const Cost& cost, const Box& box, const Settings& settings = {},
                  const std::function<void(double)>& progress = {});

}  // namespace plenum::host::identify::swarm
