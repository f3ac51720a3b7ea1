// valve_hysteresis: the spool sticks until the command has moved by its backlash.
//
//   x(t) = min(max(x(t-), u - w/2), u + w/2)                                            (play operator)
//
// u command, x effective command [V]; w width of the loop [V]. Assumptions: rate-independent, no creep. Vanishes
// at w = 0, where x = u. Numerical treatment: exact for a held command; x starts in the middle of the play.
// Source: Visintin, Differential Models of Hysteresis (1994), III.2; valve dead band and hysteresis as measured
// in "Pressure regulator valve", section II.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 1> kValveHysteresisParameters{{
    {"width_V", "of the loop: command change at a reversal that moves nothing", 0.0, 1.5, 0.0, 0.05},
}};
inline constexpr Effect kValveHysteresis{
    "valve_hysteresis",
    Equation::command,
    "after a reversal the valve stays where it is until the command has crossed its backlash",
    "x = clamp(x, u - w/2, u + w/2)",
    "play operator (Visintin 1994)",
    kValveHysteresisParameters};

template <class N>
class ValveHysteresis {
 public:
  void prepare(const N* x, double command_V) {
    half_V_ = 0.5 * x[0];
    place_V_ = N(command_V);
  }
  N follow(const N& command) {
    place_V_ = smaller(larger(place_V_, command - half_V_), command + half_V_);
    return place_V_;
  }

 private:
  N half_V_{}, place_V_{};
};

}  // namespace plenum::host::effects
