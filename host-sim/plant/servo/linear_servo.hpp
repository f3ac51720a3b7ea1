// The cylinder linearised at rest, as transfer functions.
//
//   mdot_1 = C_f1 x_s - C_p1 P_1,  mdot_2 = -C_f2 x_s - C_p2 P_2                                         (24)
//   x(s) = G(s) U(s) - G_d(s) F_d(s)                                                                     (25)
//   G   = gamma R T k_v [A_1 C_f1 Q_2 + A_2 C_f2 Q_1] / ((tau_v s + 1) D)                                (26)
//   G_d = Q_1 Q_2 / D                                                                                    (27)
//   D   = s (M s + F) Q_1 Q_2 + gamma s [A_1^2 P_10 Q_2 + A_2^2 P_20 Q_1]                                (28)
//   Q_j = gamma R T C_pj + V_j0 s
//
// x position [m]; U command [V]; F_d force against +x [N]; x_s command after the spool [V]; C_f flow gain
// [kg/(s V)], C_p flow-pressure coefficient [kg/(s Pa)]; gamma exponent of the chamber (k adiabatic, 1
// isothermal); R [J/(kg K)]; T [K]; A_j piston areas [m2]; V_j0, P_j0 volumes and pressures at the operating
// point; M moving mass [kg]; F viscous friction [N s/m]; k_v valve gain [-], tau_v valve time constant [s].
// All are deviations from rest at the operating point.
//
// As printed, (24) has +C_f2 while the plus in (26) needs the minus above (one chamber fills as the other
// empties); (26)-(28) lack the s of V_10 s where they mean Q_1; and (28) has alpha gamma A^3 where (11),
// (12), (22) give gamma A^2 (with A^3 its two terms are not of one unit unless alpha is in 1/m2).
// `as_printed` keeps the printed form with alpha, for comparison.
// Assumptions: small deviations, viscous friction alone, gas at constant temperature in the flow term. Range:
// C_p >= 0, V, P, M > 0. Numerical treatment: closed form; poles by the companion matrix.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (24)-(28).
#pragma once

#include <Eigen/Core>
#include <complex>

#include "host-sim/plant/servo/cylinder_rates.hpp"

namespace plenum::host::plant::servo {

/// Rest: position, command after the spools (5/3, mirrored) and pressures at which nothing moves.
struct OperatingPoint {
  double position_m = 0.0;
  double command_V = 5.0;
  double pressure_1_Pa = 0.0;  ///< P_10
  double pressure_2_Pa = 0.0;  ///< P_20
};

/// The rest of a cylinder without dry friction at `position_m`: no net flow in either chamber, no net force.
/// Throws std::invalid_argument when no command from 0 to 10 V holds it.
OperatingPoint operating_point(const ServoCylinderConfig& config, const ValvePair& valves, double position_m);

struct LinearServo {
  double gamma = 1.4;
  double gas_constant_J_kg_K = 287.0;  ///< R
  double temperature_K = 293.15;       ///< T
  double area_1_m2 = 0.0;
  double area_2_m2 = 0.0;
  double flow_gain_1_kg_s_V = 0.0;       ///< C_f1
  double flow_gain_2_kg_s_V = 0.0;       ///< C_f2
  double flow_pressure_1_kg_s_Pa = 0.0;  ///< C_p1
  double flow_pressure_2_kg_s_Pa = 0.0;  ///< C_p2
  double volume_1_m3 = 0.0;              ///< V_10
  double volume_2_m3 = 0.0;              ///< V_20
  double pressure_1_Pa = 0.0;            ///< P_10
  double pressure_2_Pa = 0.0;            ///< P_20
  double mass_kg = 1.0;                  ///< M
  double viscous_N_s_m = 0.0;            ///< F
  double valve_gain = 1.0;               ///< k_v
  double valve_time_constant_s = 0.0;    ///< tau_v
};

/// The coefficients of (24)-(28) at `point`; gamma is the exponent of the chamber's law, tau_v that of a lag
/// with the same delay as the spool of (1), 2 zeta / omega.
LinearServo linearise(const ServoCylinderConfig& config, const ValvePair& valves, const OperatingPoint& point,
                      double gamma);

/// G(s) of (26) [m/V] and G_d(s) of (27) [m/N].
std::complex<double> command_response(const LinearServo& servo, std::complex<double> s);
std::complex<double> force_response(const LinearServo& servo, std::complex<double> s);

/// D of (28), coefficients of s^0 .. s^4.
Eigen::Matrix<double, 5, 1> characteristic_polynomial(const LinearServo& servo);

/// The four roots of D [1/s], by rising real part.
Eigen::Vector4cd poles(const LinearServo& servo);

/// The two terms of (28) with the signs, powers and missing s of the print; area A_1 for A, `alpha` as
/// printed.
struct PrintedDenominator {
  std::complex<double> inertia;   ///< s (M s + F) (gamma R T C_p1 + V_10) (gamma R T C_p2 + V_20 s)
  std::complex<double> pressure;  ///< alpha gamma A^3 s [gamma R T (..) + (..) s]
};
PrintedDenominator as_printed(const LinearServo& servo, double alpha, std::complex<double> s);

/// d(rates)/d(state), d/d(command) of the 5/3 valve after the spools, d/d(F_d), by central differences of
/// sliding_rates() without dry friction.
struct NumericalLinearisation {
  Eigen::Matrix<double, 6, 6> by_state;
  Eigen::Matrix<double, 6, 1> by_command_V;
  Eigen::Matrix<double, 6, 1> by_force_N;
};
NumericalLinearisation linearise_numerically(const ServoCylinderConfig& config, const ValvePair& valves,
                                             const OperatingPoint& point);

}  // namespace plenum::host::plant::servo
