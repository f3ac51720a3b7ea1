// The valve: a plunger held between its spring and a diaphragm under the regulated pressure, and a spool that
// it pushes open.
//
//   x >= 0  plunger and spool move together, the inlet opens                       (condition 1, V (17)-(24))
//     (m_e + m_c) x'' = -(B_me + B_mc) x' - (k_me + k_mc) x + A_d (p_atm - p) + k_me x_p
//   x < 0   the spool rests on its stop, the plunger has left it and is the exhaust   (condition 2, V (25))
//     m_e x'' = -B_me x' - k_me x + A_d (p_atm - p) + k_me x_p
//   p' = gamma R T / V (q_m - q_e)                                                               (V (8), (9))
//   q_m = k_1 max(x - d, 0) k_a p_sup,  q_e = k_2 max(-x, 0) k_a p      while blocked        (V (12)-(16))
//   beyond the blocked range the same times the isentropic nozzle's flow over its blocked flow    (V Fig. 2)
//
// x displacement of the plunger, down is positive, 0 where the spool sits on its stop [m]; x_p that of the
// screw [m]; p pressure, absolute [Pa]; q_m, q_e mass flows in and out [kg/s]; d overlap of the spool [m]
// (config.hpp); the other symbols in config.hpp.
//
// Assumptions, the paper's: perfect gas of one temperature, kinetic energy neglected, volume constant, no
// leakage, viscous friction only, supply constant. Ours, where the paper gives no equation:
// - The paper parts its conditions at p = p*, "because the spool displacement is mechanically limited". At rest
//   p = p* is x = 0; in motion the stop is where it is, so that the conditions part at x = 0 here.
// - At the stop the spool loses its velocity; a plunger that meets it shares its momentum with it.
// - Joined, they stay in touch: the spool's damping could hold it back behind a rising plunger at
//   x < B_mc |x'| / k_mc only (6 um at the 1.3 mm/s of a hand).
// - Dead band and hysteresis have no mechanism in the paper. Here the spool overlaps its port by d: the plunger
//   moves by d from where the exhaust shuts to where the inlet opens. One number then gives what Fig. 6 shows:
//   nothing happens over the first 0.9 mm of the screw nor over 0.9 mm after it turned back, and in between the
//   pressure stays.
// Range: p_atm <= p <= p_sup, any screw. Vanishes (dead band, hysteresis) at d = 0.
//
// Numerical treatment: Runge-Kutta of the fourth order at a fixed step of at most a tenth of the fastest time
// constant of the mechanics and half of the volume's, which is fastest at equal pressures (0.14 ms for the bench
// valve); the crossing of x = 0, where mass and velocity jump, is found by bisection to 1e-12 of a step. The port's
// kink at x = d is not located: it costs 1e-5 of span at most (a test holds it against CVODE).
//
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods".
#pragma once

#include <array>

#include "host-sim/plant/orifice.hpp"
#include "host-sim/plant/regulator_valve/config.hpp"

namespace plenum::host::plant::regulator_valve {

struct ValveState {
  double plunger_m = 0.0;
  double plunger_m_s = 0.0;
  double pressure_Pa = 1e5;  ///< absolute
  double supplied_kg = 0.0;  ///< through the inlet since the start
  double vented_kg = 0.0;    ///< through the exhaust since the start
};

/// Flows through the ports of a valve at one displacement and pressure.
class Ports {
 public:
  /// Throws as validate(config).
  explicit Ports(const ValveConfig& config);

  /// q_m [kg/s] from the supply, V (13), (15).
  double inlet_kg_s(double plunger_m, double pressure_Pa) const;
  /// q_e [kg/s] to the atmosphere, V (14), (16).
  double exhaust_kg_s(double plunger_m, double pressure_Pa) const;

 private:
  ThinPlate nozzle_;
  double supply_Pa_;
  double ambient_Pa_;
  double inlet_width_m_;
  double exhaust_width_m_;
  double overlap_m_;
};

class Valve {
 public:
  /// At rest with the screw at `screw_m`, the volume at `pressure_Pa` (absolute). The plunger stands where its
  /// forces balance. Throws std::invalid_argument as validate(config), for a screw that is not finite, and for
  /// a pressure outside [p_atm, p_sup].
  Valve(const ValveConfig& config, double screw_m, double pressure_Pa);

  /// Moves on by `duration_s` > 0 while the screw turns evenly to `screw_m`. Throws std::invalid_argument.
  void advance(double screw_m, double duration_s);

  const ValveState& state() const { return state_; }
  double screw_m() const { return screw_m_; }
  /// Plunger and spool in touch: condition 1.
  bool joined() const { return joined_; }

 private:
  using Vector = std::array<double, 5>;  // x, x', p, supplied, vented
  struct Turn {                          // of the screw over the interval: x_p = from + rate t
    double from_m;
    double rate_m_s;
  };
  Vector slope(const Vector& y, double screw_m) const;
  Vector stepped(const Vector& y, const Turn& turn, double t_s, double h_s) const;
  void meet_or_part(Vector& y);

  ValveConfig config_;
  Ports ports_;
  double filling_Pa_kg_;  // gamma R T / V
  double longest_step_s_;
  double screw_m_;
  bool joined_;
  ValveState state_;
};

/// Where the plunger's forces balance with the screw at `screw_m` and the volume at `pressure_Pa`, from (24)
/// or (25) [m].
double plunger_at_rest_m(const ValveConfig& config, double screw_m, double pressure_Pa);

}  // namespace plenum::host::plant::regulator_valve
