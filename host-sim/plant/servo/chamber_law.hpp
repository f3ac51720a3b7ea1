// What the gas of a cylinder chamber does: four laws of one form.
//
//   polytropic      Pdot = n R T_i / (V (P/P_i)^(1/n - 1)) mdot - n P Vdot / V                           (10)
//   adiabatic       Pdot = k R T / V (mdot_in - mdot_out) - k P Vdot / V                     (11), (12), (15)
//   isothermal      Pdot = R T / V (mdot_in - mdot_out) - P Vdot / V                                     (18)
//   mixed           Pdot = R T / V (alpha_in mdot_in - alpha_out mdot_out) - alpha P Vdot / V      (19), (21)
//   energy balance  (V Pdot + P Vdot) / (k-1) = q + k C_v (mdot_in T_in - mdot_out T) - P Vdot     (13), (14)
//
// P pressure, absolute [Pa]; V volume [m3]; mdot = mdot_in - mdot_out mass flows [kg/s]; T temperature of the
// gas [K]; index i: at the start; R gas constant for each kilogram [J/(kg K)]; k ratio of specific heats;
// C_v = R/(k-1); n polytropic index; alpha between 1 and k; q heat from the wall [W], here G_w (T_w - T);
// T_in temperature of the gas that enters.
//
// Assumptions: perfect gas, one pressure and temperature in the chamber, kinetic and potential energy of the
// gas neglected. Range: P, V, T > 0; 1 <= n, alpha <= k for what air in a cylinder does.
//
// How they hang together (the tests hold them to it):
//   * R T_i (P/P_i)^(1-1/n) is R T of a gas on its polytrope, so (10) needs no memory of its start once T is
//     taken as P V / (m R): (10) at n = k is (15), at n = 1 it is (18), and P (V/m)^n stays constant.
//   * (13)-(14) with q = 0 and T_in = T is (15); with G_w without bound it is (18) at T = T_w.
//   * (19) at alpha = 1 is (18); at alpha = k it is (15) only if its T is the gas's own and not a constant.
//     With a constant T and alpha other than 1 it does not keep P V = m R T.
// Signs: (12) and (21) are printed with the piston term of chamber 1 for both chambers, and (10) with it
// reversed; all follow from (6), (8), (20) with Vdot, which is what is used here.
// Numerical treatment: none here; cylinder.hpp integrates.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (6)-(21).
#pragma once

#include <variant>

#include "host-sim/plant/gas.hpp"

namespace plenum::host::plant::servo {

/// The gas of a chamber: its pressure and its mass, each by its own balance.
struct ChamberState {
  double pressure_Pa = 101325.0;
  double mass_kg = 0.0;
};

/// What passes the ports; both flows are at or above 0.
struct Throughflow {
  double in_kg_s = 0.0;
  double out_kg_s = 0.0;
};

/// A volume and how fast it grows.
struct ChamberVolume {
  double volume_m3 = 0.0;
  double rate_m3_s = 0.0;
};

/// (10), with the gas's own temperature: n = k adiabatic (15), n = 1 isothermal (18).
struct Polytropic {
  double index = 1.4;
};

/// (19), (21) at the constant temperature of the gas.
struct MixedExponents {
  double entering = 1.4;     ///< alpha_in
  double leaving = 1.0;      ///< alpha_out
  double compression = 1.2;  ///< alpha
};

/// (13), (14): entering gas at the temperature of Gas, heat through the wall.
struct EnergyBalance {
  double wall_conductance_W_K = 0.0;  ///< G_w; 0: no heat
  double wall_temperature_K = 293.15;
};

using ChamberLaw = std::variant<Polytropic, MixedExponents, EnergyBalance>;

/// Throws std::invalid_argument naming the field, its value and its range.
void validate(const ChamberLaw& law);

/// m of a perfect gas: P V / (R T) [kg].
double mass_of_kg(const Gas& gas, double pressure_Pa, double volume_m3, double temperature_K);

/// T of a perfect gas: P V / (m R) [K].
double temperature_of_K(const Gas& gas, const ChamberState& state, double volume_m3);

/// The temperature that the law gives to the gas in the chamber, and so to what leaves it.
double temperature_under_K(const ChamberLaw& law, const Gas& gas, const ChamberState& state,
                           double volume_m3);

/// Pdot of the law [Pa/s].
double pressure_rate_Pa_s(const ChamberLaw& law, const Gas& gas, const ChamberState& state,
                          const Throughflow& flow, const ChamberVolume& volume);

/// (10) with its reference state, as printed but for the sign of the piston's term [Pa/s].
double polytropic_rate_Pa_s(const Gas& gas, double index, const ChamberState& state, double start_pressure_Pa,
                            double start_temperature_K, const Throughflow& flow, const ChamberVolume& volume);

/// (17): the heat that keeps a chamber at its temperature [W], into the gas.
double isothermal_heat_W(const Gas& gas, const ChamberState& state, const Throughflow& flow,
                         const ChamberVolume& volume);

}  // namespace plenum::host::plant::servo
