// Masses, springs, diaphragm and ports of the valve from its two sampled models.
//
//   (32) solved for c_1..c_8, then (28), (29), (26) for seven unknowns:
//   m_e = B_me/c_6, m_c = (B_me + B_mc)/c_2 - m_e, k_me = c_7 m_e, k_mc = c_3 (m_e + m_c) - k_me,
//   A_d = k_me c_4/c_1, k_1 = c_1 (m_e + m_c) V/(k_a k_me p_sup gamma R T),
//   p_eq = k_me x_eq/A_d, k_2 = c_5 m_e V/(k_a k_me p_eq gamma R T)
//
// Eight coefficients for seven unknowns: c_8 gives A_d again, from the exhaustion.
// What this can be trusted for: the mechanics (m, k) are in c_2, c_3, c_6, c_7, that is in poles of milliseconds,
// which 5 ms of sample time and a pascal of noise hide; A_d in the static gain, which is well known.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods", section 5, Tables 2 and 3.
#pragma once

#include "host-sim/identify/regulator_valve/discrete_model.hpp"

namespace plenum::host::identify::regulator_valve {

/// Table 3.
struct SystemConstants {
  double gamma_R_T_J_kg = 1.4 * 287.04 * 298.0;
  double volume_m3 = 149.74e-6;
  double supply_Pa = 8e5;
  double blocked_flow_s_m = 2.34e-3;    ///< k_a
  double plunger_damping_N_s_m = 12.0;  ///< B_me
  double spool_damping_N_s_m = 12.0;    ///< B_mc
  double rest_screw_m = 2.69e-3;        ///< x_eq of (26)
};

/// Table 2.
struct InternalParameters {
  double diaphragm_area_m2 = 0.0;             ///< A_d
  double plunger_mass_kg = 0.0;               ///< m_e
  double spool_mass_kg = 0.0;                 ///< m_c
  double plunger_spring_N_m = 0.0;            ///< k_me
  double spool_spring_N_m = 0.0;              ///< k_mc
  double inlet_width_m = 0.0;                 ///< k_1
  double exhaust_width_m = 0.0;               ///< k_2
  double rest_Pa = 0.0;                       ///< p_eq of (26)
  double exhaustion_diaphragm_area_m2 = 0.0;  ///< A_d again, from c_8
};

/// Throws CannotIdentify where a coefficient that divides is 0, naming it.
InternalParameters internal_parameters(const DiscreteModel& rising, const DiscreteModel& falling,
                                       const SystemConstants& constants = {});

}  // namespace plenum::host::identify::regulator_valve
