// The orifice of the servo paper, in its own letters.
//
//   mdot = C_f A_v C1 P_u / sqrt(T)                                                P_d / P_u <= P_cr      (2)
//        = C_f A_v C2 P_u / sqrt(T) (P_d/P_u)^(1/k) sqrt(1 - (P_d/P_u)^((k-1)/k))  P_d / P_u >  P_cr
//   C1 = sqrt(k / R (2 / (k + 1))^((k+1)/(k-1)))  [sqrt(K) s/m],  C2 = sqrt(2 k / (R (k - 1)))            (3)
//   P_cr = (2 / (k + 1))^(k/(k-1))
//
// mdot [kg/s]; C_f discharge coefficient [-]; A_v area [m2]; P_u, P_d upstream and downstream pressure [Pa];
// T upstream temperature [K]; k ratio of specific heats [-]; R gas constant, for each kilogram [J/(kg K)].
// Assumptions: perfect gas, isentropic up to the throat, quasi-steady. Range: 0 < P_d <= P_u, k > 1.
// Vanishes: at equal pressures and at zero area.
// It is the thin plate of plant/orifice.hpp: C_f C1 / sqrt(T) is its beta, C_f C2 / sqrt(T) its alpha, and
// 1 / P_cr its theta; the cylinder flows through that one (with its slopes and its chord at equal pressures),
// and the tests hold the two to each other. Numerical treatment: none, closed form.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (2), (3).
#pragma once

namespace plenum::host::plant::servo {

struct OrificeConstants {
  double choked;          ///< C1 [sqrt(K) s/m]
  double subsonic;        ///< C2 [sqrt(K) s/m]
  double critical_ratio;  ///< P_cr [-]: choked at and below this ratio of downstream to upstream pressure
};

/// C1 = 0.040418, C2 = 0.156174, P_cr = 0.528, as printed for air.
inline constexpr OrificeConstants kPrintedForAir{0.040418, 0.156174, 0.528};

/// (3). Throws std::invalid_argument when kappa is not above 1 or the gas constant not above 0.
OrificeConstants orifice_constants(double kappa, double gas_constant_J_kg_K);

/// (2) with C_f A_v = `effective_area_m2` [kg/s]; 0 < downstream <= upstream, else std::invalid_argument.
double orifice_flow_kg_s(const OrificeConstants& constants, double kappa, double effective_area_m2,
                         double upstream_Pa, double downstream_Pa, double temperature_K);

}  // namespace plenum::host::plant::servo
