// The paper's equations letter by letter, for what is asked of the paper itself rather than of our plant.
// Source: "Modeling and Identification of Pneumatic Actuators" (1), (3), (8), (9), (10).
#pragma once

#include <array>
#include <cmath>

#include "host-sim/plant/gas.hpp"

namespace plenum::host::reproduce::actuators::printed {

/// (1c) [kg/(s m2)]; pressures [Pa].
inline double z(double p_u, double p_d, const plant::ThinPlateConstants& c) {
  if (p_u / p_d > c.theta) return c.beta_s_m * p_u;
  const double x = p_d / p_u;
  return c.alpha_s_m * p_u * std::sqrt(std::pow(x, 2.0 / c.kappa) - std::pow(x, (c.kappa + 1.0) / c.kappa));
}

/// (1b) [kg/(s m2)].
inline double phi(double p_u, double p_d, const plant::ThinPlateConstants& c) {
  return p_u >= p_d ? z(p_u, p_d, c) : -z(p_d, p_u, c);
}

/// The smooth max(x, 0) of (3).
inline double smax(double x) {
  return 0.5 * (std::sqrt(x * x + 1.0) + x);
}

/// (3a), (3b): areas in the unit of L and B.
inline double compressor_area(double u, double L_c, double U_c, double B) {
  return L_c + smax((u - U_c) * B - L_c);
}
inline double room_area(double u, double L_r, double U_r, double B) {
  return L_r + smax((U_r - u) * B - L_r);
}

/// (8).
inline double g(double x) {
  return x / std::sqrt(x * x + 1.0);
}

/// (9).
inline double k(double x, double a, double b, double c) {
  return std::sqrt(x * x + a * a) - a + b + c * x;
}

/// What (10) takes besides u, v, v', p. c[0] is c_1; c_b, c_s [kPa]; c_gamma [V].
struct Parameters {
  std::array<double, 9> c{};
  double c_b = 0.0;
  double c_s = 0.0;
  double c_gamma = 0.1;
};

/// The compact form below (10f).
inline double compact_rate(const Parameters& m, double p, double u, double v, double v_rate) {
  const auto& [c1, c2, c3, c4, c5, c6, c7, c8, c9] = m.c;
  const double U = u - c1;
  const double cubic = c2 * U + c3 * U * U * U;
  return (m.c_b + m.c_s * cubic / std::sqrt(cubic * cubic + 1.0) + c4 * v_rate - p) *
         (c7 * (std::sqrt(U * U + m.c_gamma * m.c_gamma) - m.c_gamma + c9 + c8 * U) + c5 * v_rate) /
         (1.0 + c6 * v);
}

}  // namespace plenum::host::reproduce::actuators::printed
