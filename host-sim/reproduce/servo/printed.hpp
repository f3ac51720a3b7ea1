// The chamber equations letter by letter as the paper prints them: nothing of the plant is in them.
//
// P pressure, absolute [Pa]; T temperature [K]; R gas constant [J/(kg K)]; k ratio of specific heats; n
// polytropic index; V volume [m3]; A piston area [m2]; x piston position, xdot its velocity [m, m/s]; mdot mass
// flows [kg/s]; index i: at the start. x counts from the middle of the stroke in (8)-(10), (20), (21), and from
// the end at which chamber 1 is smallest in (11), (12). Upper signs are those of chamber 1.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (8)-(21).
#pragma once

#include <cmath>

namespace plenum::host::reproduce::servo::printed {

/// One side of the cylinder; (8) has x_0 for half the stroke and A x_m for the dead volume.
struct Side {
  double sign;      ///< of "+-": 1 for chamber 1, -1 for chamber 2
  double area_m2;   ///< A_j
  double stroke_m;  ///< L
  double dead_m3;   ///< V_mj, V_jo, V_0

  double x_0() const { return 0.5 * stroke_m; }
  double x_m() const { return dead_m3 / area_m2; }
};

/// A chamber's gas and what passes its ports.
struct Filling {
  double P, T;
  double mdot_in, mdot_out;

  double mdot() const { return mdot_in - mdot_out; }
};

struct Alphas {
  double in, out, piston;
};

/// (8): A (x_0 +- x + x_m) [m3].
inline double volume_8(const Side& j, double x) {
  return j.area_m2 * (j.x_0() + j.sign * x + j.x_m());
}

/// (9) has it as A (x_0 +- x +- x_m) [m3].
inline double volume_9(const Side& j, double x) {
  return j.area_m2 * (j.x_0() + j.sign * x + j.sign * j.x_m());
}

/// (12): A_2 (L - x) + V_2o, x from the end of the stroke [m3].
inline double volume_12(const Side& j, double x) {
  return j.area_m2 * (j.stroke_m - x) + j.dead_m3;
}

/// (20): V_0 + A (L/2 +- x) [m3].
inline double volume_20(const Side& j, double x) {
  return j.dead_m3 + j.area_m2 * (0.5 * j.stroke_m + j.sign * x);
}

/// (10): n R T_i / (A (x_0 +- x + x_m) (P/P_i)^(1/n-1)) mdot +- n P / (x_0 +- x + x_m) xdot [Pa/s].
inline double rate_10(const Side& j, double R, double n, double P_i, double T_i, const Filling& f, double x,
                      double xdot) {
  const double height = j.x_0() + j.sign * x + j.x_m();
  return n * R * T_i / (j.area_m2 * height * std::pow(f.P / P_i, 1.0 / n - 1.0)) * f.mdot() +
         j.sign * n * f.P / height * xdot;
}

/// (11): k R T mdot_1 = (k A_1 xdot) P_1 + (A_1 x + V_1o) Pdot_1, for Pdot_1 [Pa/s].
inline double rate_11(const Side& one, double R, double k, const Filling& f, double x, double xdot) {
  return (k * R * f.T * f.mdot() - k * one.area_m2 * xdot * f.P) / (one.area_m2 * x + one.dead_m3);
}

/// (12): k R T mdot_2 = (k A_2 xdot) P_2 + [A_2 (L - x) + V_2o] Pdot_2, for Pdot_2 [Pa/s].
inline double rate_12(const Side& two, double R, double k, const Filling& f, double x, double xdot) {
  return (k * R * f.T * f.mdot() - k * two.area_m2 * xdot * f.P) / volume_12(two, x);
}

/// (15): k R T / V (mdot_in - mdot_out) - k P / V Vdot [Pa/s].
inline double rate_15(double R, double k, const Filling& f, double V, double Vdot) {
  return k * R * f.T / V * f.mdot() - k * f.P / V * Vdot;
}

/// (17): q_in - q_out = P Vdot - P/rho (mdot_in - mdot_out), P/rho = R T [W].
inline double heat_17(double R, const Filling& f, double Vdot) {
  return f.P * Vdot - R * f.T * f.mdot();
}

/// (18): R T / V (mdot_in - mdot_out) - P / V Vdot [Pa/s].
inline double rate_18(double R, const Filling& f, double V, double Vdot) {
  return R * f.T / V * f.mdot() - f.P / V * Vdot;
}

/// (21): R T / V_j (alpha_in mdot_in - alpha_out mdot_out) - alpha P A_j / V_j xdot, V_j of (20) [Pa/s].
inline double rate_21(const Side& j, double R, const Alphas& alpha, const Filling& f, double x, double xdot) {
  const double V = volume_20(j, x);
  return R * f.T / V * (alpha.in * f.mdot_in - alpha.out * f.mdot_out) -
         alpha.piston * f.P * j.area_m2 / V * xdot;
}

}  // namespace plenum::host::reproduce::servo::printed
