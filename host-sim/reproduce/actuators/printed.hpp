// The paper's equations letter by letter, for what is asked of the paper itself rather than of our plant.
// Source: "Modeling and Identification of Pneumatic Actuators" (1), (3), (8)-(13), Table II.
#pragma once

#include <array>
#include <cmath>

namespace plenum::host::reproduce::actuators::printed {

/// Table II: M [kg/mol], R [Pa m3/(mol K)], C, Z, kappa [-]. It leaves T [K] open; ours is 20 degC.
struct TableTwo {
  double M = 0.029;
  double R = 8.31;
  double C = 0.72;
  double Z = 0.99;
  double kappa = 1.4;
  double T = 293.15;
};

/// (11) [s/m].
inline double alpha(const TableTwo& of) {
  const auto& [M, R, C, Z, kappa, T] = of;
  return C * std::sqrt(2.0 * M / (Z * R * T) * kappa / (kappa - 1.0));
}

/// (12) [s/m].
inline double beta(const TableTwo& of) {
  const auto& [M, R, C, Z, kappa, T] = of;
  return C *
         std::sqrt(kappa * M / (Z * R * T) * std::pow(2.0 / (kappa + 1.0), (kappa + 1.0) / (kappa - 1.0)));
}

/// (13) [-].
inline double theta(double kappa) {
  return std::pow((kappa + 1.0) / 2.0, kappa / (kappa - 1.0));
}

/// (1c) [kg/(s m2)]; pressures [Pa].
inline double z(double p_u, double p_d, const TableTwo& of) {
  if (p_u / p_d > theta(of.kappa)) return beta(of) * p_u;
  const double x = p_d / p_u;
  return alpha(of) * p_u * std::sqrt(std::pow(x, 2.0 / of.kappa) - std::pow(x, (of.kappa + 1.0) / of.kappa));
}

/// (1b) [kg/(s m2)].
inline double phi(double p_u, double p_d, const TableTwo& of) {
  return p_u >= p_d ? z(p_u, p_d, of) : -z(p_d, p_u, of);
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
