// valve_hysteresis: the spool sticks until the command has moved by its backlash.
//
//   x = (1 - r) y + r (u - z w/2),   y(t) = min(max(y(t-), u - w/2), u + w/2),   dz/du = (sgn u' - z)/(d w/2)
//
// u command, x effective command [V]; w width of the loop [V]; y the play operator, a friction that sticks or slides; z
// Dahl's friction, which creeps before it slides; r share of the latter, which rounds the loop's corners, d its reach in
// half widths [-]. Assumptions: rate-independent. Vanishes at w = 0, where x = u; r = 0 is the play alone. Numerical
// treatment: exact for a held command; y and z start in the middle of the loop. Source: Visintin, Differential Models of
// Hysteresis (1994), III.2; Dahl, AIAA Journal 14 (1976), the Bouc-Wen model of exponent 1; valve dead band and
// hysteresis as measured in "Pressure regulator valve", section II.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 3> kValveHysteresisParameters{{
    {"width_V", "of the loop: command change at a reversal that moves nothing", 0.0, 1.5, 0.0, 0.05},
    {"rounding", "r: share of creep before sliding", 0.0, 1.0, 0.0, 0.1, Coordinate::linear, true},
    {"reach", "d: how far it creeps, in half widths", 2.0, 20.0, 2.0, 0.5, Coordinate::linear, true},
}};
inline constexpr Effect kValveHysteresis{
    "valve_hysteresis",
    Equation::command,
    "after a reversal the valve stays where it is until the command has crossed its backlash",
    "x = (1 - r) clamp(y, u - w/2, u + w/2) + r (u - z w/2), dz/du = (sgn u' - z)/(d w/2)",
    "play operator (Visintin 1994), Dahl (1976)",
    kValveHysteresisParameters};

template <class N>
class ValveHysteresis {
 public:
  void prepare(const N* x, double command_V) {
    half_V_ = 0.5 * x[0];
    rounding_ = x[1];
    per_reach_ = 1.0 / larger(half_V_ * x[2], N(1e-6));
    command_V_ = N(command_V);
    creep_ = N(0.0);
    place_V_ = N(command_V);
  }
  N follow(const N& command) {
    place_V_ = smaller(larger(place_V_, command - half_V_), command + half_V_);
    const N move = command - command_V_;
    command_V_ = command;
    const N end = select(move < N(0.0), N(-1.0), N(1.0));
    creep_ = end + (creep_ - end) * exponential(-magnitude(move) * per_reach_).e;
    return place_V_ + rounding_ * (command - half_V_ * creep_ - place_V_);
  }

 private:
  N half_V_{}, rounding_{}, per_reach_{}, place_V_{}, command_V_{}, creep_{};
};

}  // namespace plenum::host::effects
