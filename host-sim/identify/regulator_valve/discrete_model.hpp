// The sampled third-order model of one condition of the valve, and its way to and from the continuous one.
//
//   p(k) = -a_1 p(k-1) - a_2 p(k-2) - a_3 p(k-3) + b x_p(k-1)                                  (V (30), (31))
//   b = c_1 t_s^3, a_1 = c_2 t_s - 3, a_2 = c_3 t_s^2 - 2 c_2 t_s + 3,
//   a_3 = c_4 t_s^3 - c_3 t_s^2 + c_2 t_s - 1                                                       (V (32))
//
// p [Pa], x_p [m]: deviations. (32) is the forward difference s = (z - 1)/t_s, whose numerator is b z^-3; the
// paper writes b z^-1 "considering the sampling input delay", and so does this. The difference is two samples
// of delay. It is stable only for |1 + s t_s| < 1 at every pole s.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods".
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "host-sim/plant/regulator_valve/linear_model.hpp"

namespace plenum::host::identify::regulator_valve {

struct DiscreteModel {
  double b_Pa_m = 0.0;        ///< b_0, b_1
  std::array<double, 3> a{};  ///< a_1, a_2, a_3 or a_4, a_5, a_6
  double sample_s = 0.005;    ///< t_s

  /// 1 + a_1 + a_2 + a_3 = c_4 t_s^3: what is left between numbers of order one. Four printed digits of each
  /// leave it known to 1.5e-4.
  double residue() const { return 1.0 + a[0] + a[1] + a[2]; }
  /// Settled pressure for each metre of the screw.
  double static_gain_Pa_m() const { return b_Pa_m / residue(); }
};

/// (32). Throws std::invalid_argument for a sample time not above 0.
DiscreteModel discretise(const plant::regulator_valve::ThirdOrder& model, double sample_s);

/// (32) solved for c_1..c_4. Throws as discretise().
plant::regulator_valve::ThirdOrder read_back(const DiscreteModel& model);

/// Roots of z^3 + a_1 z^2 + a_2 z + a_3, the largest modulus first.
std::array<std::complex<double>, 3> poles(const DiscreteModel& model);
/// Roots of s^3 + c_2 s^2 + c_3 s + c_4 [1/s], the slowest (largest real part) first.
std::array<std::complex<double>, 3> poles(const plant::regulator_valve::ThirdOrder& model);

/// All poles within the unit circle; in the left half plane.
bool stable(const DiscreteModel& model);
bool stable(const plant::regulator_valve::ThirdOrder& model);

/// -t_s / ln |z| of the slowest pole; -1 / Re s of it [s]. Infinite where the model is not stable.
double slowest_time_constant_s(const DiscreteModel& model);
double slowest_time_constant_s(const plant::regulator_valve::ThirdOrder& model);

/// The model run freely over `screw_m` from the first three of `pressure_Pa`; deviations, equal lengths. Throws
/// std::invalid_argument for unequal lengths or less than three.
std::vector<double> free_run(const DiscreteModel& model, const std::vector<double>& screw_m,
                             const std::vector<double>& pressure_Pa);

}  // namespace plenum::host::identify::regulator_valve
