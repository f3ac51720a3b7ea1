// The grey-box valve behind a volume of fluid that a pump feeds: the circuit of the classical model, with the
// valve reduced to (3.14).
//
//   dP/dt = (beta / V)(Q_supply - a sqrt(2 P / rho)),   lag da/dt = k1 P + k3 - a,  a >= 0
//
// P upstream pressure over the tank's [Pa]; V upstream volume [m3]; beta bulk modulus [Pa]; the rest as in
// grey_box.hpp.
// Assumptions: those of (3.14); constant bulk modulus; tank pressure 0. Vanishes (the valve follows the
// supply flow) as V -> 0. Range: lag > 0, steps well below lag and the period of the pair. Numerical
// treatment: while shut P rises in closed form; the instant of opening and of shutting is located; in between
// the classical Runge-Kutta method with equal steps between those instants.
// Source: "Grey-Box Multi-Port Models of Fluid Power Valves", (3.14) with I.A of its appendix A.
#pragma once

#include "host-sim/plant/relief_valve/grey_box.hpp"

namespace plenum::host::plant::relief_valve {

struct GreyBoxCircuitConfig {
  GreyBoxConfig valve;  ///< constant damping, lag > 0
  double upstream_volume_m3 = 4e-3;
  double bulk_modulus_Pa = 1.4e9;
};

class GreyBoxInCircuit {
 public:
  /// At rest, passing `flow_m3_s` >= 0 (at 0: shut, without pressure). Throws std::invalid_argument.
  GreyBoxInCircuit(const GreyBoxCircuitConfig& config, double flow_m3_s);

  /// Moves on by one Runge-Kutta step with the supply going linearly from one flow to the other [m3/s, >= 0].
  void advance(double from_m3_s, double to_m3_s, double step_s);

  double pressure_Pa() const { return pressure_Pa_; }
  double valve_flow_m3_s() const;

 private:
  struct Rate {
    double pressure_Pa_s, opening_m2_s;
  };
  Rate rate(double pressure_Pa, double opening_m2, double supply_m3_s) const;
  bool shut() const { return opening_m2_ == 0.0 && pressure_Pa_ <= cracks_Pa_; }
  double advance_shut(double from_m3_s, double slope_m3_s2, double step_s);
  double advance_open(double from_m3_s, double slope_m3_s2, double step_s);

  GreyBoxConfig valve_;
  double stiffness_Pa_m3_;  // beta / V
  double root_2_over_density_;
  double cracks_Pa_;
  double pressure_Pa_ = 0.0;
  double opening_m2_ = 0.0;
};

}  // namespace plenum::host::plant::relief_valve
