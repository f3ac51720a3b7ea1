// supply_droop: the supply falls while it is drawn from, and recovers.
//
//   P = P_0 - s,   tau s' = R m_in - s
//
// P supply at the valve, P_0 at rest [Pa]; s droop [Pa]; m_in flow into the chamber [kg/s]; R source resistance
// [Pa s/kg]; tau time constant of the line's volume behind the regulator [s]. Assumptions: linear source, alone on
// its line. Vanishes at R = 0. Numerical treatment: s relaxes exactly over a step with the step's mean flow; the
// step itself sees s at its middle, from a linearly implicit half step: second order. tau is at least 5 ms, below
// which it is not told from none; P is held above a fifth of P_0. Source: a regulator's flow characteristic (its
// droop), "Pressure regulator valve", section III.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kSupplyDroopParameters{{
    {"resistance_kPa_s_per_g", "droop for each gram a second", 0.0, 400.0, 0.0, 2.0},
    {"recovery_s", "time constant", 0.005, 3.0, 0.05, 0.05},
}};
inline constexpr Effect kSupplyDroop{
    "supply_droop",
    Equation::supply,
    "the supply pressure falls with the flow that is drawn, and recovers after it",
    "P = P_0 - s, tau s' = R m_in - s",
    "flow characteristic of a pressure regulator",
    kSupplyDroopParameters};

template <class N>
class SupplyDroop {
 public:
  void prepare(const N* x, double step_s) {
    resistance_ = x[0] * 1e6;
    keep_ = each(x[1], [&](double tau) { return std::exp(-step_s / tau); });
    keep_half_ = each(x[1], [&](double tau) { return std::exp(-0.5 * step_s / tau); });
    droop_Pa_ = N(0.0);
  }
  /// Supply at the valve; held above a fifth of that at rest.
  N supply(const N& at_rest_Pa) const { return supply(at_rest_Pa, droop_Pa_); }
  /// Half a step on, the flow being `flow_kg_s` now and falling with the supply by `slope_kg_s_Pa`: implicit, as a
  /// chamber nearly filled draws a flow that a small droop stops.
  N supply_at_middle(const N& at_rest_Pa, const N& flow_kg_s, const N& slope_kg_s_Pa) const {
    const N gain = (1.0 - keep_half_) * resistance_;
    return supply(at_rest_Pa, (keep_half_ * droop_Pa_ + gain * (flow_kg_s + slope_kg_s_Pa * droop_Pa_)) /
                                  (1.0 + gain * slope_kg_s_Pa));
  }
  /// A step passes, with this mean flow.
  void draw(const N& flow_kg_s) {
    const N steady = resistance_ * flow_kg_s;
    droop_Pa_ = steady + keep_ * (droop_Pa_ - steady);
  }

 private:
  static N supply(const N& at_rest_Pa, const N& droop_Pa) {
    return larger(at_rest_Pa - droop_Pa, 0.2 * at_rest_Pa);
  }
  N resistance_{}, keep_{}, keep_half_{}, droop_Pa_{};
};

}  // namespace plenum::host::effects
