// valve_hysteresis: the spool sticks until the command has moved by its backlash.
//
//   x = (1 - r) y + r (u - z w/2),   y(t) = min(max(y(t-), u - w/2), u + w/2)
//   dz/du = (1 - z (b sgn u' + (1 - b) sgn z))/(d b w/2)
//
// u command, x effective command [V]; w width of the loop [V]; y the play operator, a friction that sticks or slides; z
// Bouc and Wen's friction of exponent 1, which creeps before it slides; r share of the latter, which rounds the loop's
// corners; d [-]: after a reversal the spool follows with 1 - 2/d of the command's speed, for d >= 2 never against it; b [-]:
// it takes hold over d b half widths, and lets go as it took hold at b = 1 (Dahl), in proportion to the command at b = 1/2;
// below, it would yield energy. Assumptions: rate-independent. Vanishes at w = 0, where x = u; r = 0 is the play alone.
// Numerical treatment: exact for a held command but for a logarithm (2e-7); y and z start in the middle of the loop. Source:
// Visintin, Differential Models of Hysteresis (1994), III.2; Dahl, AIAA Journal 14 (1976); Bouc (1967) and Wen, J. Eng.
// Mech. Div. 102 (1976); Erlicher and Point, C. R. Mecanique 332 (2004), for the bound of b; valve dead band and
// hysteresis as measured in "Pressure regulator valve", section II.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 4> kValveHysteresisParameters{{
    {"width_V", "of the loop: command change at a reversal that moves nothing", 0.0, 1.5, 0.0, 0.05},
    {"rounding", "r: share of creep before sliding", 0.0, 1.0, 0.0, 0.1, Coordinate::linear, true},
    {"reach", "d: after a reversal it moves by 1 - 2/d of the command", 2.0, 20.0, 2.0, 0.5,
     Coordinate::linear, true},
    {"letting_go", "b: 1 lets go as it took hold, 1/2 in proportion", 0.5, 1.0, 1.0, 0.1, Coordinate::linear,
     true},
}};
inline constexpr Effect kValveHysteresis{
    "valve_hysteresis",
    Equation::command,
    "after a reversal the valve stays where it is until the command has crossed its backlash",
    "x = (1 - r) clamp(y, u - w/2, u + w/2) + r (u - z w/2), dz/du = (1 - z (b sgn u' + (1 - b) sgn z))/(d b "
    "w/2)",
    "play operator (Visintin 1994), Bouc (1967) and Wen (1976), Dahl (1976) for b = 1",
    kValveHysteresisParameters};

template <class N>
class ValveHysteresis {
 public:
  void prepare(const N* x, double command_V) {
    half_V_ = 0.5 * x[0];
    rounding_ = x[1];
    per_reach_ = 1.0 / larger(half_V_ * x[2] * x[3], N(1e-6));
    yielding_ = 2.0 * x[3] - 1.0;
    command_V_ = N(command_V);
    creep_ = N(0.0);
    place_V_ = N(command_V);
  }
  N follow(const N& command) {
    place_V_ = smaller(larger(place_V_, command - half_V_), command + half_V_);
    const N move = command - command_V_;
    command_V_ = command;
    // m: friction along the movement. While it holds against it, m < 0, m' = 1 - (2 b - 1) m; then m' = 1 - m.
    const N along = select(move < N(0.0), N(-1.0), N(1.0));
    const N way = magnitude(move) * per_reach_;
    const N held = larger(-(along * creep_), N(0.0));
    const N back = smaller(way, held * log_per(yielding_ * held));
    const Exponential<N> let_go = exponential(-(yielding_ * back));
    const N m = select(held > N(0.0), back * let_go.phi_1 - held * let_go.e, along * creep_);
    creep_ = along * (1.0 + (m - 1.0) * exponential(back - way).e);
    return place_V_ + rounding_ * (command - half_V_ * creep_ - place_V_);
  }

 private:
  /// ln(1 + x)/x for x in 0 .. 1, to 2e-7: 2 artanh(t)/x with t = x/(2 + x).
  static N log_per(const N& x) { return 2.0 * artanh_per(x / (2.0 + x)) / (2.0 + x); }

  N half_V_{}, rounding_{}, per_reach_{}, yielding_{}, place_V_{}, command_V_{}, creep_{};
};

}  // namespace plenum::host::effects
