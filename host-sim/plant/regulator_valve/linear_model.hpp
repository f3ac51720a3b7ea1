// The linear third-order models of the valve about a rest in the blocked range.
//
//   P(s)/X_p(s) = c_1 / (s^3 + c_2 s^2 + c_3 s + c_4)                pressurisation, p <= p*          (V (28))
//   P(s)/X_p(s) = c_5 / (s^3 + c_6 s^2 + c_7 s + c_8)                exhaustion, p > p*               (V (29))
//
//   c_1 = k_1 k_a k_me p_sup gamma R T/(m_ec V)   c_2 = (B_me + B_mc)/m_ec   c_3 = (k_me + k_mc)/m_ec
//   c_4 = k_1 k_a A_d p_sup gamma R T/(m_ec V)    m_ec = m_e + m_c
//   c_5 = k_2 k_a k_me p_eq gamma R T/(m_e V)     c_6 = B_me/m_e             c_7 = k_me/m_e
//   c_8 = k_2 k_a A_d p_eq gamma R T/(m_e V)
//
// P, X_p deviations of pressure [Pa] and screw [m]; p_eq the absolute pressure of the rest (V (26), (27)).
// Assumptions: blocked flow, that is (10): p_atm/0.528 <= p <= 0.528 p_sup; pressurisation is linear there,
// exhaustion is linearised. The dead band only shifts x_p. Numerical treatment: none, closed form.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods".
#pragma once

#include "host-sim/plant/regulator_valve/config.hpp"

namespace plenum::host::plant::regulator_valve {

/// b / (s^3 + a2 s^2 + a1 s + a0): c_1, c_2, c_3, c_4 or c_5, c_6, c_7, c_8 in this order.
struct ThirdOrder {
  double gain_Pa_m_s3 = 0.0;   ///< c_1, c_5
  double square_1_s = 0.0;     ///< c_2, c_6
  double linear_1_s2 = 0.0;    ///< c_3, c_7
  double constant_1_s3 = 0.0;  ///< c_4, c_8

  /// Settled pressure for each metre of the screw: c_1/c_4 = k_me/A_d.
  double static_gain_Pa_m() const { return gain_Pa_m_s3 / constant_1_s3; }
};

/// (28). Throws as validate(config).
ThirdOrder linear_pressurisation(const ValveConfig& config);
/// (29) about `rest_Pa` (absolute). Throws as validate(config), and for a pressure not above 0.
ThirdOrder linear_exhaustion(const ValveConfig& config, double rest_Pa);

/// The absolute pressures between which both ports are blocked, (10): p_atm / r and r p_sup with
/// r = (2/(gamma+1))^(gamma/(gamma-1)) = 0.528.
struct BlockedRange {
  double low_Pa;
  double high_Pa;
};
BlockedRange blocked_range(const ValveConfig& config);

}  // namespace plenum::host::plant::regulator_valve
