// valve_hysteresis: the spool sticks until the command has moved by its backlash.
//
//   x = u - h m,   dm/du = s L/(z + g L),   h = w/2,  g = c h,  z = (d + 2 b (1 - c)) h
//   L = 1 - s m while the friction holds (s m > 0, s = sgn u'),  else 1 - (2 b - 1) s m
//
// u command, x effective command [V]; w width of the loop [V]; m friction, of the greatest. At c = 1 the spool hangs on a spring
// of its command, and the friction takes hold over the spool's own way, dm/dx = s L/(d h): Dahl's at b = 1, Bouc and Wen's of
// exponent 1 below. At c = 0 it takes hold over the way of the command; between, part of the spring lies on either side of it.
// d [-]: where the friction is at its greatest the spool follows a reversal with d/(d + 2 b) of the command's speed, whatever c,
// and never against it; d = 0, c = 1 is the play operator. b [-]: 1 lets go as it took hold, 1/2 in proportion; below, it would
// yield energy. Assumptions: rate-independent; m is all that is remembered, so that but for the play an inner loop does not close
// where it began. Vanishes at w = 0, where x = u. Numerical treatment: exact for a held command, over a way y of which
// z ln(L0/L) + g (L0 - L) = k y, k = 1 while it holds, else 2 b - 1: L = Wright's omega function times z/g (m to 2e-4: c and
// 2 b - 1 begin at 1e-4). m starts in the middle of the loop. Source: Visintin, Differential Models of Hysteresis (1994), III.2;
// Dahl, AIAA Journal 14 (1976); Bouc (1967) and Wen, J. Eng. Mech. Div. 102 (1976); Erlicher and Point, C. R. Mecanique 332
// (2004), for the bound of b; valve dead band and hysteresis as measured in "Pressure regulator valve", section II.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 4> kValveHysteresisParameters{{
    {"width_V", "of the loop: command change at a reversal that moves nothing", 0.0, 1.5, 0.0, 0.05},
    {"softness", "d: a reversal at full friction moves it by d/(d + 2 b) of the command", 0.0, 10.0, 0.0, 0.1,
     Coordinate::linear, true},
    {"spring", "c: share of the spring between command and friction", 0.0, 1.0, 1.0, 0.1, Coordinate::linear,
     true},
    {"letting_go", "b: 1 lets go as it took hold, 1/2 in proportion", 0.5, 1.0, 1.0, 0.1, Coordinate::linear,
     true},
}};
inline constexpr Effect kValveHysteresis{
    "valve_hysteresis",
    Equation::command,
    "after a reversal the valve stays where it is until the command has crossed its backlash",
    "x = u - m w/2, dm/du = s L/(d + 2 b (1 - c) + c L)/(w/2), L = 1 - s m, or 1 - (2 b - 1) s m letting go",
    "play operator (Visintin 1994), Dahl (1976), Bouc (1967) and Wen (1976)",
    kValveHysteresisParameters};

template <class N>
class ValveHysteresis {
 public:
  void prepare(const N* x, double command_V) {
    half_V_ = 0.5 * x[0];
    const N half_V = larger(half_V_, N(kLeastHalf_V));
    const N straight = kLeastStraight + (1.0 - kLeastStraight) * x[2];
    by_log_V_ = larger(x[1] + 2.0 * x[3] * (1.0 - straight), N(kLeastByLog)) * half_V;
    straight_V_ = straight * half_V;
    yielding_ = kLeastYielding + (1.0 - kLeastYielding) * (2.0 * x[3] - 1.0);
    command_V_ = N(command_V);
    friction_ = N(0.0);
  }
  N follow(const N& command) {
    const N move = command - command_V_;
    const N way = magnitude(move);
    command_V_ = command;
    const auto moves = way > N(0.0);
    if (any(moves)) {
      const N along = select(move < N(0.0), N(-1.0), N(1.0));
      N m = along * friction_;
      N ahead = way;
      const N against = larger(-m, N(0.0));
      if (any(against > N(0.0))) {
        // all of it is let go over z ln(1 + k a)/k + g a
        const N free = against * (by_log_V_ * log_per(yielding_ * against) + straight_V_);
        const N left = (1.0 - loose(1.0 + yielding_ * against, yielding_ * smaller(way, free))) / yielding_;
        m = select(against > N(0.0), select(way < free, left, N(0.0)), m);
        ahead = larger(way - free, N(0.0));
      }
      const auto holds = ahead > N(0.0);
      if (any(holds)) m = select(holds, 1.0 - loose(larger(1.0 - m, N(kLeastLoose)), ahead), m);
      friction_ = select(moves, along * m, friction_);
    }
    return command - half_V_ * friction_;
  }

 private:
  /// Of the half width, and of what the friction lets go by: below these the equations divide by zero. The two that a bound of a figure
  /// leads to are where its range begins, so that a small change of the figure is felt there.
  static constexpr double kLeastHalf_V = 1e-6, kLeastByLog = 1e-9, kLeastStraight = 1e-4,
                          kLeastYielding = 1e-4, kLeastLoose = 1e-12;

  /// What L above becomes over `way_V`, k y above.
  N loose(const N& before, const N& way_V) const {
    const N straight = straight_V_ * before;
    return by_log_V_ / straight_V_ *
           wright_omega(logarithm(straight / by_log_V_) + (straight - way_V) / by_log_V_);
  }
  /// ln(1 + x)/x for x in 0 .. 1, to 2e-7: 2 artanh(t)/x with t = x/(2 + x).
  static N log_per(const N& x) { return 2.0 * artanh_per(x / (2.0 + x)) / (2.0 + x); }

  N half_V_{}, by_log_V_{}, straight_V_{}, yielding_{};  ///< h, z, g, 2 b - 1
  N command_V_{}, friction_{};
};

}  // namespace plenum::host::effects
