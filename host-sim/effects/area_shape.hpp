// area_shape: a port's area is not linear in the command.
//
//   a(u) = L + w smax((B o m(o) - L)/w),  o = u - U (inlet), U - u (exhaust) where it is open,
//   m(o) = 1 + q g + c g^2 + e g^3,  g = o / (o + 2 V)
//
// o opening [V]; m ratio of the area to the linear one; q, c, e shape of each port [-]. m runs from 1 at the null to
// 1 + q + c + e at full stroke: progressive where q > 0, saturating where q < 0. Assumptions: smooth, monotone where
// m is bounded as below. Vanishes at q = c = e = 0. Numerical treatment: m is held above 0.05. Source: measured
// tables of "Proportional directional flow control valve" (Tables 1 to 5), whose areas are S-shaped.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 6> kAreaShapeParameters{{
    {"inlet_slope", "q of the inlet", -6.0, 20.0, 0.0, 0.3},
    {"inlet_curve", "c of the inlet", -20.0, 20.0, 0.0, 0.5},
    {"exhaust_slope", "q of the exhaust", -6.0, 20.0, 0.0, 0.3},
    {"exhaust_curve", "c of the exhaust", -20.0, 20.0, 0.0, 0.5},
    {"inlet_bend", "e of the inlet", -40.0, 40.0, 0.0, 0.8, Coordinate::linear, true},
    {"exhaust_bend", "e of the exhaust", -40.0, 40.0, 0.0, 0.8, Coordinate::linear, true},
}};
inline constexpr Effect kAreaShape{
    "area_shape",
    Equation::valve_area,
    "the ports' areas are not linear in the command: progressive, S-shaped or saturating",
    "a = L + w smax((B o (1 + q g + c g^2 + e g^3) - L)/w), g = o/(o + 2 V)",
    "Proportional directional flow control valve, Tables 1 to 5",
    kAreaShapeParameters};

template <class N>
class AreaShape {
 public:
  void prepare(const N* x) { x_ = x; }
  N inlet(const N& opening_V) const { return opening_V * ratio(opening_V, x_[0], x_[1], x_[4]); }
  N exhaust(const N& opening_V) const { return opening_V * ratio(opening_V, x_[2], x_[3], x_[5]); }

 private:
  static N ratio(const N& opening_V, const N& q, const N& c, const N& e) {
    const N o = larger(opening_V, N(0.0));
    const N g = o / (o + 2.0);
    return larger(1.0 + g * (q + g * (c + e * g)), N(0.05));
  }
  const N* x_ = nullptr;
};

}  // namespace plenum::host::effects
