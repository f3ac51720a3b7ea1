// A manual pressure regulator valve: its constants, and the one that stands on the simulated bench.
//
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods", Tables 2 and 3, section 4.
#pragma once

#include "host-sim/plant/gas.hpp"

namespace plenum::host::plant::regulator_valve {

/// Air of V Table 3: R = 287.04 J/(kg K), T = 298 K, gamma = 1.4.
Gas table3_air();

/// Symbols in brackets are those of V. The defaults are a valve that does on the bench what V section 4 says
/// of the real one: bench_valve() derives them.
struct ValveConfig {
  Gas gas = table3_air();
  double supply_Pa = 8e5;               ///< p_sup, absolute
  double ambient_Pa = 1e5;              ///< p_atm
  double volume_m3 = 149.74e-6;         ///< V: valve, line and sensor
  double plunger_mass_kg = 17.30e-3;    ///< m_e
  double spool_mass_kg = 16.77e-3;      ///< m_c; moves with the plunger while it touches it
  double plunger_damping_N_s_m = 12.0;  ///< B_me
  double spool_damping_N_s_m = 12.0;    ///< B_mc
  double plunger_spring_N_m = 2607.63;  ///< k_me
  double spool_spring_N_m = 2705.23;    ///< k_mc
  double diaphragm_area_m2 = 0.0;       ///< A_d
  double inlet_width_m = 0.0;           ///< k_1: area of the inlet for each metre of the spool
  double exhaust_width_m = 0.0;         ///< k_2: area of the exhaust for each metre of the plunger
  double dead_band_m = 0.0;             ///< of the screw; 0: V (13), (24) as printed
};

/// What V section 4 states of the real valve, from which the bench valve is made.
struct Behaviour {
  double slope_Pa_m = 1.56e8;               ///< settled pressure for each metre of the screw
  double pressurisation_time_s = 0.15;      ///< time constant of Fig. 5
  double exhaustion_time_s = 0.5;           ///< V prints none: the slowest pole of (31) with (38) is 0.48 s
  double exhaustion_pressure_Pa = 3.059e5;  ///< absolute; the middle of (10), where exhaustion_time_s holds
  double dead_band_m = 0.9e-3;              ///< of Fig. 6
};

/// Masses, springs and damping of V Table 2 (PSO) and Table 3; A_d, k_1 and k_2 such that the valve behaves as
/// told, since those of Table 2 do not (see the README). With the slow pole alone, masses and damping left out:
///   A_d = k_me / slope,  k_1 = (k_me + k_mc) V / (gamma R T k_a p_sup A_d tau),
///   k_2 = k_me V / (gamma R T k_a p A_d tau_e)
/// Throws std::invalid_argument where a number of `behaviour` is not above 0 (the dead band: below 0).
ValveConfig bench_valve(const Behaviour& behaviour = {});

/// Throws std::invalid_argument naming the field, its value and its range.
void validate(const ValveConfig& config);

/// k_a = sqrt(gamma/(R T) (2/(gamma+1))^((gamma+1)/(gamma-1))) of V (12), (15) [s/m]: blocked flow for each
/// square metre and pascal upstream.
double blocked_flow_s_m(const Gas& gas);

/// gamma R T [J/kg] of V (8), (9).
double gamma_R_T_J_kg(const Gas& gas);

/// How far the spool moves before the inlet opens [m]: dead_band k_me / (k_me + k_mc). The springs share the
/// screw's travel in that ratio, so that the screw has to turn through the dead band.
double overlap_m(const ValveConfig& config);

}  // namespace plenum::host::plant::regulator_valve
