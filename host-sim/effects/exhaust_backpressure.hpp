// exhaust_backpressure: a silencer or manifold raises the pressure behind the exhaust port.
//
//   P = P_a + s,   tau s' = sqrt(P_a^2 + (R m_ex)^2) - P_a - s
//
// P pressure behind the port, P_a ambient [Pa]; m_ex flow out of the chamber [kg/s]; R resistance of the silencer
// [Pa s/kg], the orifice law far from choking at its inlet; tau time constant of the volume between [s].
// Assumptions: alone on the manifold. Vanishes at R = 0. It acts only where the exhaust is not choked. Numerical
// treatment: as of supply_droop. Source: ISO 6358 series resistance.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kExhaustBackpressureParameters{{
    {"resistance_kPa_s_per_g", "of the silencer, P^2 - P_a^2 = (R m)^2", 0.0, 400.0, 0.0, 10.0},
    {"settling_s", "time constant of the volume before it", 0.005, 1.0, 0.01, 0.02},
}};
inline constexpr Effect kExhaustBackpressure{
    "exhaust_backpressure",
    Equation::mass_flow,
    "the pressure behind the exhaust port rises with the flow through silencer or manifold",
    "P^2 = P_a^2 + (R m_ex)^2, with a first-order lag",
    "ISO 6358, resistances in series",
    kExhaustBackpressureParameters};

template <class N>
class ExhaustBackpressure {
 public:
  void prepare(const N* x, double step_s) {
    resistance_ = x[0] * 1e6;
    keep_ = each(x[1], [&](double tau) { return std::exp(-step_s / tau); });
    keep_half_ = each(x[1], [&](double tau) { return std::exp(-0.5 * step_s / tau); });
    above_Pa_ = N(0.0);
  }
  N behind(const N& ambient_Pa) const { return ambient_Pa + above_Pa_; }
  /// Half a step on, the flow being `flow_kg_s` now and falling as this pressure rises by `slope_kg_s_Pa`: implicit, as
  /// a chamber nearly empty vents a flow that a small pressure stops.
  N behind_at_middle(const N& ambient_Pa, const N& flow_kg_s, const N& slope_kg_s_Pa) const {
    const N end = steady(flow_kg_s, ambient_Pa);
    const N gain = (1.0 - keep_half_) * resistance_ * resistance_ * larger(flow_kg_s, N(0.0)) /
                   (ambient_Pa + end) * slope_kg_s_Pa;
    return ambient_Pa + (keep_half_ * above_Pa_ + (1.0 - keep_half_) * end + gain * above_Pa_) / (1.0 + gain);
  }
  /// A step passes, with this mean flow.
  void vent(const N& flow_kg_s, const N& ambient_Pa) {
    const N end = steady(flow_kg_s, ambient_Pa);
    above_Pa_ = end + keep_ * (above_Pa_ - end);
  }

 private:
  N steady(const N& flow_kg_s, const N& ambient_Pa) const {
    const N loss = resistance_ * larger(flow_kg_s, N(0.0));
    return root(ambient_Pa * ambient_Pa + loss * loss) - ambient_Pa;
  }
  N resistance_{}, keep_{}, keep_half_{}, above_Pa_{};
};

}  // namespace plenum::host::effects
