// The spool: second-order lag between the commanded and the effective command.
//
//   M_s x'' + C_s x' + 2 k_s x = K_fc i_c                                                             (C1)
//   in volts of command, x scaled to unit gain:  x'' + 2 zeta omega x' + omega^2 x = omega^2 u
//   omega = sqrt(2 k_s / M_s) [rad/s], zeta = C_s / (2 sqrt(2 k_s M_s)) [-]; u command [V]; x effective
//   command [V]
//
// Assumptions: friction force F_f neglected (as the paper allows), coil current proportional to the command,
// no end stops. Range: omega > 0, zeta > 0. Vanishes as omega grows without bound: x = u; "off" is the
// absence of a spool. Numerical treatment: closed form for a held command. With e = x - u, sigma = zeta
// omega:
//   (e, e')(t) = exp(-sigma t) [[C + sigma S, S], [-omega^2 S, C - sigma S]] (e, e')(0)
//   C = cos(w_d t), S = sin(w_d t) / w_d, w_d = omega sqrt(1 - zeta^2); hyperbolic for zeta > 1, 1 and t at
//   zeta = 1.
// Source: C: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems", (1).
#pragma once

#include <cmath>

namespace plenum::host::plant {

struct SpoolConfig {
  double natural_frequency_Hz = 65.0;  ///< omega / 2 pi
  double damping_ratio = 0.7;          ///< zeta
};

class Spool {
 public:
  /// At rest at `command_V`. Throws std::invalid_argument when frequency or damping is not above 0.
  Spool(const SpoolConfig& config, double command_V);

  /// Moves on by `duration_s` with `command_V` held.
  void advance(double command_V, double duration_s);

  /// At rest on the command, to 1e-9 V in position and in rate over omega.
  bool settled_on(double command_V) const;

  /// How far it still moves: distance to the command and rate over omega, together.
  double off_V(double command_V) const {
    return std::abs(effective_V_ - command_V) + std::abs(rate_V_s_) / omega_rad_s_;
  }

  /// Comes to rest on the command.
  void settle(double command_V);

  double effective_V() const { return effective_V_; }
  double rate_V_s() const { return rate_V_s_; }
  double natural_frequency_rad_s() const { return omega_rad_s_; }

 private:
  struct Transition {  // the matrix of the closed form for one duration
    double duration_s = -1.0;
    double xx = 0.0, xv = 0.0, vx = 0.0, vv = 0.0;
  };
  Transition transition(double duration_s) const;

  double omega_rad_s_;
  double damping_ratio_;
  double effective_V_;
  double rate_V_s_ = 0.0;
  Transition latest_;  // calm ticks ask for the same duration again and again
};

}  // namespace plenum::host::plant
