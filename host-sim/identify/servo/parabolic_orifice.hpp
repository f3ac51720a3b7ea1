// Valve flow by the orifice equation, its area a parabola in the command: what (5) is to be better than.
//
//   mdot = (A_0 + A_1 u + A_2 u^2) q(P_u, P_d)        q the flow of 1 m2 by (2), at 293.15 K
//
// mdot mass flow [kg/s]; u command [V]; A_i effective area C_f A_v [m2 per V^i]. Upstream is the supply and
// downstream the chamber at an inlet, chamber and surroundings at an exhaust; where the chamber is beyond
// the other side (no flow of this way) q is 0.
// Assumptions: constant supply and ambient. Range: that of the samples' commands, all pressures.
// Method: linear least squares by QR, u scaled to -1..1. Source: "Mathematical and Intelligent Modeling of
// Electropneumatic Servo Actuator Systems" (2), (3).
#pragma once

#include <array>
#include <span>

#include "host-sim/identify/servo/flow_samples.hpp"

namespace plenum::host::identify::servo {

struct Port {
  bool inlet = true;  ///< from the supply into the chamber; else from the chamber to the surroundings
  double supply_Pa = 700e3;
  double ambient_Pa = 100e3;
};

struct ParabolicOrifice {
  Port port;
  std::array<double, 3> area_m2{};  ///< A_0, A_1, A_2
  double flow_kg_s(double command_V, double pressure_Pa) const;
};

struct ParabolicOrificeFit : FlowError {
  ParabolicOrifice orifice;
};

/// Throws as fit_bipolynomial().
ParabolicOrificeFit fit_parabolic_orifice(std::span<const FlowSample> samples, const Port& port);

}  // namespace plenum::host::identify::servo
