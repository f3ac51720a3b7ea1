// exhaust_backpressure: a silencer or manifold raises the pressure behind the exhaust port.
//
//   P = P_a + s,   tau s' = sqrt(P_a^2 + (R m_ex)^2) - P_a - s
//
// P pressure behind the port, P_a ambient [Pa]; m_ex flow out of the chamber [kg/s]; R resistance of the silencer
// [Pa s/kg], the orifice law far from choking at its inlet; tau time constant of the volume between [s].
// Assumptions: alone on the manifold. Vanishes at R = 0. Numerical treatment: s relaxes exactly over a step. It
// acts only where the exhaust is not choked. Source: ISO 6358 series resistance.
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
    above_Pa_ = N(0.0);
  }
  N behind(const N& ambient_Pa) const { return ambient_Pa + above_Pa_; }
  void vent(const N& flow_kg_s, const N& ambient_Pa) {
    const N loss = resistance_ * larger(flow_kg_s, N(0.0));
    const N steady = root(ambient_Pa * ambient_Pa + loss * loss) - ambient_Pa;
    above_Pa_ = steady + keep_ * (above_Pa_ - steady);
  }

 private:
  N resistance_{}, keep_{}, above_Pa_{};
};

}  // namespace plenum::host::effects
