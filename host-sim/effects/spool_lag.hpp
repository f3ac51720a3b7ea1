// spool_lag: the spool follows its command as a damped mass on a spring.
//
//   tau (1 +- a) (1 +- b) c' = u - c,   v' = w^2 (c - x) - 2 zeta w v,   x' = v/(1 + |v/S|^n)^(1/n)
//
// u command, c current of the coil, x effective command [V]; w = 2 pi f natural frequency [rad/s]; zeta damping [-]; tau
// the coil's time constant [s], a by how much of it the current rises more slowly (+) than it falls (-): a freewheeling
// diode; b by how much more slowly it comes back to the null (+), between the thresholds, than it leaves it (-): a spool
// that a magnet pulls away and a spring returns; S greatest speed of the spool [V/s], that of saturated current and of flow
// forces; n [-] how suddenly it is met, 2 where nothing else is known. Assumptions: no stop. Vanishes at f -> infinity
// with tau = 0 and S -> infinity, which is x'' = w^2 (u - x) - 2 zeta w x'. Numerical treatment: closed form for a command
// held over a step (second_order.hpp), in which c enters by its mean. What enters is the mean of x over the step, from the
// equation integrated over it,
//   int (x - u) = -(x1' - x0')/w^2 - 2 zeta (x1 - x0)/w:
// exact at any w, so that a spool faster than the step is late by the right area, 2 zeta/w to the first order. With a
// speed limit the way of the step is cut by the limit at its mean speed, and v regains what the spring then keeps.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (1); coil and slew rate
// of proportional valves: Merritt, Hydraulic Control Systems (1967), 7.
#pragma once

#include <array>
#include <numbers>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"
#include "host-sim/effects/second_order.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 7> kSpoolLagParameters{{
    {"natural_frequency_Hz", "of the spool on its spring", 2.0, kInfinity, kInfinity, 0.02,
     Coordinate::reciprocal},
    {"damping", "damping ratio", 0.3, 10.0, 0.8, 0.3},
    {"slew_V_s", "S: greatest speed of the spool", 5.0, kInfinity, kInfinity, 2e-5,
     Coordinate::reciprocal_square, true},
    {"coil_s", "tau: time constant of the coil's current", 0.0, 0.05, 0.0, 0.001, Coordinate::linear, true},
    {"coil_rise", "a: share by which it rises more slowly than it falls", -0.9, 0.9, 0.0, 0.2,
     Coordinate::linear, true},
    {"coil_return", "b: share by which it comes back to the null more slowly than it leaves it", -0.9, 0.9,
     0.0, 0.2, Coordinate::linear, true},
    {"slew_sharpness", "n: how suddenly the greatest speed is met", 1.0, 12.0, 2.0, 0.5, Coordinate::linear,
     true},
}};
inline constexpr Effect kSpoolLag{
    "spool_lag",
    Equation::command,
    "the valve's spool follows the command late: a mass on a spring, behind a coil, of limited speed",
    "x'' = w^2 (c - x) - 2 zeta w x', w = 2 pi f, |x'| < S, tau (1 +- a) (1 +- b) c' = u - c",
    "Electropneumatic servo (1)",
    kSpoolLagParameters};

template <class N>
class SpoolLag {
 public:
  /// `x`: 1/f [s], zeta, 1/S^2 [s^2/V^2], tau, a, b and n; `step_s`: what one call of follow() spans; `null_V`: of the valve.
  void prepare(const N* x, double step_s, double command_V, const N& null_V) {
    const N tau_s = x[0] * x[1] * (1.0 / std::numbers::pi);
    mass_.prepare(tau_s, 1.0 / (x[1] * x[1]), step_s);
    per_slew2_ = x[2] * (1.0 / (step_s * step_s));
    sharpness_ = x[6];
    round_ = !any(magnitude(x[6] - 2.0) > N(0.0));
    // half of w h: what the spring gives to v/w, held below 1 for a spool faster than the step
    regain_ = 2.0 * x[1] * each(x[0], [&](double period_s) {
                return period_s > 0.0 ? 1.0 / (1.0 + period_s / (std::numbers::pi * step_s)) : 0.0;
              });
    null_V_ = null_V;
    for (const bool rises : {false, true}) {
      for (const bool returns : {false, true}) {
        coils_[rises][returns] =
            Coil(x[3] * (1.0 + (rises ? 1.0 : -1.0) * x[4]) * (1.0 + (returns ? 1.0 : -1.0) * x[5]), step_s);
      }
    }
    current_V_ = N(command_V);
    place_V_ = N(command_V);
    speed_V_ = N(0.0);
  }

  /// One step with `command` held; returns the mean of x over it.
  N follow(const N& command) {
    const auto rises = current_V_ < command;
    const auto returns = magnitude(command - null_V_) < magnitude(current_V_ - null_V_);
    const auto coil = [&](N Coil::*figure) {
      return select(rises, select(returns, coils_[1][1].*figure, coils_[1][0].*figure),
                    select(returns, coils_[0][1].*figure, coils_[0][0].*figure));
    };
    const N current_end = command + coil(&Coil::keep) * (current_V_ - command);
    const N current = command - coil(&Coil::per_step) * (current_end - current_V_);
    current_V_ = current_end;
    const N off = place_V_ - current;
    const auto end = mass_.after_step({off, speed_V_});
    const N way = end.off - off;
    const N mean = current - mass_.late(way, end.speed - speed_V_);
    const N kept = 1.0 - moved(per_slew2_ * way * way);  // of the way, by the limit
    const N late = kept * (mean - place_V_);
    place_V_ = current + end.off - kept * way;
    speed_V_ = end.speed + regain_ * kept * way;
    return mean - late;
  }

 private:
  /// What the current keeps of its way over a step, and its time constant in steps.
  struct Coil {
    N keep{}, per_step{};

    Coil() = default;
    Coil(const N& tau_s, double step_s)
        : keep(each(tau_s, [&](double tau) { return tau > 0.0 ? std::exp(-step_s / tau) : 0.0; })),
          per_step(tau_s * (1.0 / step_s)) {}
  };

  /// 1/(1 + q^n)^(1/n), q the way over what the limit allows.
  N moved(const N& q2) const {
    if (round_) return 1.0 / root(1.0 + q2);
    const N q = root(q2), most = larger(q, N(1.0));
    const N share = larger(smaller(q, N(1.0)) / most, N(kLeastShare));  // q or 1/q, whichever is less than 1
    return power(1.0 + power(share, sharpness_), -1.0 / sharpness_) / most;
  }
  static constexpr double kLeastShare = 1e-9;

  SecondOrder<N> mass_;
  N per_slew2_{}, sharpness_{}, regain_{};
  bool round_ = true;                                 ///< every lane's n is 2
  Coil coils_[2][2];                                  ///< rises, returns
  N null_V_{}, current_V_{}, place_V_{}, speed_V_{};  ///< the speed as 2 zeta v/w
};

}  // namespace plenum::host::effects
