// Friction of a sliding seal, and what holds a piston at rest.
//
//   F_f = F_c sgn(v) + F_s exp(-|v/v_s|^delta) sgn(v) + F_v v                                            (23)
//
// v sliding velocity [m/s]; F_c Coulomb friction [N]; F_s Stribeck friction, the excess of static friction
// over Coulomb's [N]; v_s its characteristic velocity [m/s]; F_v viscous friction [N s/m]; delta: 1 as
// printed. The text calls the form Gaussian, which is delta = 2.
//
// At rest friction is no function of v: it is whatever the other forces ask for, up to the breakaway force
// F_c + F_s, the limit of (23) as v -> 0. A piston below it does not move at all (cylinder.hpp keeps it at
// rest and finds the instant at which it lets go; no sgn is smoothed, so that nothing creeps).
// Assumptions: one force for each velocity (no pre-sliding displacement, no dwell time, no frictional lag).
// Range: F_c, F_s, F_v >= 0, v_s > 0, delta > 0. Vanishes: F_c = F_s = F_v = 0. Numerical treatment: none.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (23).
#pragma once

namespace plenum::host::plant::servo {

struct Friction {
  double coulomb_N = 0.0;               ///< F_c
  double stribeck_N = 0.0;              ///< F_s
  double stribeck_velocity_m_s = 0.01;  ///< v_s
  double viscous_N_s_m = 0.0;           ///< F_v
  double stribeck_exponent = 1.0;       ///< delta

  /// F_c + F_s [N].
  double breakaway_N() const { return coulomb_N + stribeck_N; }
};

/// Throws std::invalid_argument naming the field, its value and its range.
void validate(const Friction& friction);

/// (23) of a piston that slides in `direction` (+1 or -1) with `velocity_m_s`; at 0 its limit from that side
/// [N].
double sliding_friction_N(const Friction& friction, double direction, double velocity_m_s);

}  // namespace plenum::host::plant::servo
