// supply_droop: the supply falls while it is drawn from, and recovers.
//
//   (tau/R) P' = m_f - m_in,   (P_0 - (1 - o) R m_f)^2 - P^2 = 20 o (R m_f)^2,   P_0 = P_rig + s (P_log - P_rig)
//
// P supply at the valve, P_0 at rest, that of the rig [Pa]; P_log what a log says of the supply, and s what share of it the valve
// sees, which other machines on the line and a compressor's cycle come in by; m_in flow into the chamber, m_f flow of the source [kg/s]; R source resistance
// [Pa s/kg]; tau time constant of the vessel behind it [s], whose volume is tau kappa R_g T/R; o share of an orifice in the
// resistance: at 0 a regulator with a straight flow characteristic, tau s' = R m_in - s for the droop s = P_0 - P; at 1 an
// orifice, which lets the more through by the root of the droop; both droop alike at a tenth of P_0. What a squeezed
// chamber pushes back leaves through the same resistance, of which a regulator lets a share v pass: at 1 it relieves, at 0
// the vessel keeps all of it. Assumptions: alone on its line; the orifice far from choking. Vanishes at R = s = 0. Numerical
// treatment: the implicit Euler rule, whose quadratic equation is solved in closed form for m_f; the step itself sees P at
// its middle, from half a step; the whole step is extrapolated from one and two: second order. tau is at least 5 ms, below
// which it is not told from none; P is held above a fifth of P_0. Source: a regulator's flow characteristic (its droop),
// "Pressure regulator valve", section III; ISO 6358 for the orifice.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 5> kSupplyDroopParameters{{
    {"resistance_kPa_s_per_g", "droop for each gram a second", 0.0, 400.0, 0.0, 2.0, Coordinate::linear,
     false, kAsItsResistance},
    {"recovery_s", "time constant", 0.005, 3.0, 0.05, 0.05},
    {"orifice_share", "o: of the resistance; 0 a straight characteristic, 1 an orifice before a vessel", 0.0,
     1.0, 0.0, 0.1, Coordinate::linear, true},
    {"relieving_share",
     "v: of what is pushed back, what the source lets out; 0 nothing, as behind a check valve", 0.0, 1.0, 1.0,
     0.3, Coordinate::linear, true},
    {"followed_share", "s: of what a log's supply is off the rig's, what the valve sees", 0.0, 1.5, 0.0, 0.3,
     Coordinate::linear, true},
}};
inline constexpr Effect kSupplyDroop{
    "supply_droop",
    Equation::supply,
    "the supply pressure falls with the flow that is drawn, and recovers after it",
    "(tau/R) P' = m_f - m_in, (P_0 - (1 - o) R m_f)^2 - P^2 = 20 o (R m_f)^2, P_0 = P_rig + s (P_log - "
    "P_rig)",
    "flow characteristic of a pressure regulator",
    kSupplyDroopParameters};

template <class N>
class SupplyDroop {
 public:
  void prepare(const N* x, double step_s, const N& at_rest_Pa) {
    resistance_ = x[0] * 1e6;
    linear_ = 1.0 - x[2];
    orifice_ = kAtATenth * x[2];
    relieving_ = x[3];
    inertia_ = x[1] * (1.0 / step_s);
    followed_ = x[4];
    follows_ = false;
    rigs_Pa_ = at_rest_Pa;
    at_rest_Pa_ = at_rest_Pa;
    supply_Pa_ = at_rest_Pa;
  }
  /// What the log says of the supply in the tick to come; at the first, where it stands.
  void follow(double logged_Pa) {
    at_rest_Pa_ = rigs_Pa_ + followed_ * (logged_Pa - rigs_Pa_);
    if (!follows_) supply_Pa_ = at_rest_Pa_;
    follows_ = true;
  }
  const N& supply_Pa() const { return supply_Pa_; }
  /// Half a step on, the flow being `flow_kg_s` now and growing with the supply by `slope_kg_s_Pa`: implicit, as a
  /// chamber nearly filled draws a flow that a small droop stops.
  N supply_at_middle_Pa(const N& flow_kg_s, const N& slope_kg_s_Pa) const {
    return after(supply_Pa_, 2.0 * inertia_ + resistance_ * slope_kg_s_Pa, flow_kg_s);
  }
  /// A step passes, with this mean flow.
  void draw(const N& flow_kg_s) {
    const N whole = after(supply_Pa_, inertia_, flow_kg_s);
    const N halves = after(after(supply_Pa_, 2.0 * inertia_, flow_kg_s), 2.0 * inertia_, flow_kg_s);
    supply_Pa_ = larger(2.0 * halves - whole, 0.2 * at_rest_Pa_);
  }

 private:
  static constexpr double kAtATenth = 20.0;

  /// `d`: R times what the vessel takes up and the chamber's slope, for each Pa. With F = R m_f the balance
  /// d (P - before) = F - R m_in enters the law of the source. What is pushed back meets it with the vessel's pressure the
  /// higher one.
  N after(const N& before_Pa, const N& d, const N& flow_kg_s) const {
    const N a = d * before_Pa - resistance_ * flow_kg_s;
    const N square = (at_rest_Pa_ * d - a) * (at_rest_Pa_ * d + a);
    const N b = at_rest_Pa_ * linear_ * d * d + a;
    const N c = (orifice_ - linear_ * linear_) * d * d + 1.0;
    const N in = square / (b + root(larger(b * b + c * square, N(0.0))));
    const N behind = at_rest_Pa_ - linear_ * in;
    const N drawn = root(larger(behind * behind - orifice_ * in * in, 0.04 * at_rest_Pa_ * at_rest_Pa_));
    const N e = 1.0 + linear_ * d;
    const N back =
        -square / (a * e + root(larger(a * a * e * e + (e * e - orifice_ * d * d) * square, N(0.0))));
    return select(square < N(0.0), (a - relieving_ * back) / d, drawn);
  }
  N resistance_{}, linear_{}, orifice_{}, relieving_{}, followed_{}, inertia_{};
  N rigs_Pa_{}, at_rest_Pa_{}, supply_Pa_{};
  bool follows_ = false;
};

}  // namespace plenum::host::effects
