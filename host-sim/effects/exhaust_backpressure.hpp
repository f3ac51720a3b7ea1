// exhaust_backpressure: a silencer or manifold raises the pressure behind the exhaust port.
//
//   V P'/(kappa R_g T) = m_ex - m_s,   (1 - 2 b) P^2 + 2 b P_b P = P_b^2 + 2 l P_b R m_s + (1 - b)^2 (R m_s)^2,   P_b = P_a + c
//
// which for b = 0 is P^2 = P_b^2 + 2 l P_b R m_s + (R m_s)^2, and for l = 0 ISO 6358's
// m_s = (P/R) sqrt(1 - ((P_b/P - b)/(1 - b))^2), or choked at P_b/P <= b, m_s = P/R.
// P pressure behind the port, P_a ambient [Pa]; c what stands there without flow, behind a spring-loaded silencer or on a
// manifold that others fill [Pa]; m_ex flow out of the chamber, m_s that through the silencer [kg/s]; R its resistance [Pa
// s/kg]; b its critical pressure ratio, 0 far from choking, m_s = sqrt(P^2 - P_b^2)/R; l share of a straight
// characteristic: at 1 P = P_b + R m_s, as of felt or sintered metal; V volume of the manifold between [m3], R_g T of its gas
// [J/kg]. Assumptions: alone on the manifold, nothing comes back from it but what stands there. Vanishes at R = c = 0. It
// acts only where the exhaust is not choked. Numerical treatment: the implicit Euler rule, whose quadratic equation is
// solved in closed form,
//   P_1 = C/(B + sqrt(B^2 + A C)),  A = 1 - 2 b - (1 - b)^2 q^2,  B = q ((1 - b)^2 E + l P_b) + b P_b,
//   C = (1 - b)^2 E^2 + 2 l P_b E + P_b^2,  q = R (V/(kappa R_g T h) + s),  E = R m + q P_0,
// or, where that is above P_b/b, of the flow R m_s = k P that goes on from there, P_1 = E/(q + k);
// s [kg/(s Pa)] by which the flow falls as P rises; at any V, also at none. The step itself sees P at its middle, from
// half a step; the whole step is extrapolated from one and two: second order. Source: ISO 6358 series resistance.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 5> kExhaustBackpressureParameters{{
    {"resistance_kPa_s_per_g", "R: of the silencer", 0.0, 400.0, 0.0, 10.0, Coordinate::linear, false,
     kAsItsResistance},
    {"manifold_mL", "V: volume of the manifold before it", 0.0, 2000.0, 0.0, 20.0, Coordinate::linear, false,
     kAsTheVolume},
    {"straight_share", "l: 0 an orifice, 1 a fabric, behind which the pressure rises straight with the flow",
     0.0, 1.0, 0.0, 0.2, Coordinate::linear, true},
    {"standing_kPa", "c: above ambient without flow", 0.0, 200.0, 0.0, 2.0, Coordinate::linear, true},
    {"critical_ratio", "b: of the silencer, choked below", 0.0, 0.7, 0.0, 0.1, Coordinate::linear, true},
}};
inline constexpr Effect kExhaustBackpressure{
    "exhaust_backpressure",
    Equation::mass_flow,
    "the pressure behind the exhaust port rises with the flow through silencer or manifold",
    "V P'/(kappa R T) = m_ex - m_s, (1 - 2 b) P^2 + 2 b P_b P = P_b^2 + 2 l P_b R m_s + (1 - b)^2 (R m_s)^2, "
    "P_b = P_a + c",
    "ISO 6358, resistances in series",
    kExhaustBackpressureParameters};

template <class N>
class ExhaustBackpressure {
 public:
  /// `gas_J_kg`: R_g T.
  void prepare(const N* x, double gas_J_kg, double kappa, double step_s, const N& ambient_Pa) {
    resistance_ = x[0] * 1e6;
    inertia_ = x[1] * (1e-6 / (kappa * gas_J_kg * step_s)) * resistance_;
    standing_Pa_ = ambient_Pa + 1e3 * x[3];
    straight_Pa_ = x[2] * standing_Pa_;
    critical_ = x[4];
    subsonic2_ = (1.0 - critical_) * (1.0 - critical_);
    // R m_s/P at the critical ratio: y = R m_s/P_b solves (1 - b)^2 y^2 + 2 l y = ((1 - b)/b)^2
    const N b = larger(critical_, N(1e-6));
    choked_ = subsonic2_ / (b * (x[2] + root(x[2] * x[2] + subsonic2_ * subsonic2_ / (b * b))));
    behind_Pa_ = standing_Pa_;
  }
  const N& behind_Pa() const { return behind_Pa_; }
  /// Half a step on; `flow(p, P)` gives {flow, by_downstream} of the open port from the pressure p before it, which is
  /// `upstream_Pa` now and falls by `fall_Pa_s_kg` of the flow until then. The flow falls as P rises: a chamber nearly
  /// empty vents a flow that a small pressure stops. Without a manifold P is found from nothing, by Newton steps that go
  /// at most half of the way to equal pressures, where the flow's slope is infinite.
  template <class Flow>
  N behind_at_middle_Pa(const N& upstream_Pa, const N& fall_Pa_s_kg, const Flow& flow) const {
    N at = behind_Pa_;
    N upstream = upstream_Pa;
    for (int i = 0; i < kSteps; ++i) {
      const auto now = flow(upstream, at);
      const N slope = -now.by_downstream;
      const N next = after(at, behind_Pa_, 2.0 * inertia_, resistance_ * slope, now.flow);
      const N held = smaller(next, larger(0.5 * (at + upstream), at));
      const N out = larger(now.flow + slope * (at - held), N(0.0));
      upstream = larger(upstream_Pa - fall_Pa_s_kg * out, 0.5 * upstream_Pa);
      at = held;
    }
    return at;
  }
  /// A step passes, with this mean flow.
  void vent(const N& flow_kg_s) {
    const N none(0.0);
    const N whole = after(none, behind_Pa_, inertia_, none, flow_kg_s);
    const N half = after(none, behind_Pa_, 2.0 * inertia_, none, flow_kg_s);
    behind_Pa_ = larger(2.0 * after(none, half, 2.0 * inertia_, none, flow_kg_s) - whole, standing_Pa_);
  }

 private:
  static constexpr int kSteps = 4;

  /// Of an implicit step from `before_Pa`: `inertia` R V/(kappa R_g T h), the flow linear about `at_Pa` with R times its
  /// slope.
  N after(const N& at_Pa, const N& before_Pa, const N& inertia, const N& slope, const N& flow_kg_s) const {
    const N q = inertia + slope;
    const N E = resistance_ * larger(flow_kg_s, N(0.0)) + slope * at_Pa + inertia * before_Pa;
    const N A = 1.0 - 2.0 * critical_ - subsonic2_ * q * q;
    const N B = q * (subsonic2_ * E + straight_Pa_) + critical_ * standing_Pa_;
    const N C = E * (subsonic2_ * E + 2.0 * straight_Pa_) + standing_Pa_ * standing_Pa_;
    const N subsonic = C / (B + root(larger(B * B + A * C, N(0.0))));
    const N choked = E / (q + choked_);
    return select(critical_ * choked > standing_Pa_, choked, subsonic);
  }
  N resistance_{}, inertia_{}, straight_Pa_{}, standing_Pa_{}, behind_Pa_{};
  N critical_{}, subsonic2_{}, choked_{};
};

}  // namespace plenum::host::effects
