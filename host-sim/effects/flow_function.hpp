// flow_function: how the flow falls with the pressure ratio differs from the thin plate's.
//
//   psi(r) = (1 + k (r* - r)) psi_0(r')^(2 beta),   r' = r* + (r - b)(1 - r*)/(a - b) for r > b, r* below
//
// r = p_d/p_u pressure ratio; psi_0 the thin plate's flow over its choked flow, r* = 0.528 its critical ratio; b
// critical ratio, of the exhaust b + e, a cracking ratio, beta subsonic index, k slope of the discharge coefficient [-].
// Assumptions: all but b the same for both ports. Range: 0.05 <= b < a <= 1, b + e held there. Vanishes at b = r*, a = 1, beta =
// 1/2, k = e = 0, exactly. Numerical
// treatment: a change of the variable of psi_0, so that the limit needs no case. Source: ISO 6358 form of
// "Proportional directional flow control valve" (4)-(6), carried over to the thin plate (1c).
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr double kThinPlateCritical = 0.5282817877171742;  ///< (2/2.4)^3.5

inline constexpr std::array<Parameter, 5> kFlowFunctionParameters{{
    {"critical_ratio", "b: choked below", 0.05, 0.8, kThinPlateCritical, 0.05},
    {"subsonic_index", "beta", 0.25, 1.5, 0.5, 0.05},
    {"cracking_ratio", "a: shut above", 0.85, 1.0, 1.0, 0.02},
    {"discharge_slope", "k: relative change of the discharge coefficient with the pressure ratio", -0.8, 0.8,
     0.0, 0.1},
    {"exhaust_ratio_more", "e: of the exhaust's critical ratio beyond b", -0.7, 0.7, 0.0, 0.05,
     Coordinate::linear, true},
}};
inline constexpr Effect kFlowFunction{
    "flow_function",
    Equation::mass_flow,
    "critical ratio, subsonic index, cracking ratio or discharge differ from the thin plate's",
    "psi = (1 + k (r* - r)) psi_0(r* + (r - b)(1 - r*)/(a - b))^(2 beta)",
    "ISO 6358; Proportional directional flow control valve (4)-(6)",
    kFlowFunctionParameters};

template <class N>
class FlowFunction {
 public:
  void prepare(const N* x) {
    index_ = 2.0 * x[1];
    slope_ = x[3];
    for (const bool exhaust : {false, true}) {
      const Parameter& critical = kFlowFunctionParameters[0];
      const N b = exhaust ? smaller(larger(x[0] + x[4], N(critical.low)), N(critical.high)) : x[0];
      ports_[exhaust] = {b, (1.0 - kThinPlateCritical) / (x[2] - b)};
    }
  }
  N ratio(const N& r, bool exhaust) const {
    const Port& port = ports_[exhaust];
    return smaller(kThinPlateCritical + (r - port.critical) * port.stretch, N(1.0));
  }
  /// What the flow is multiplied with; `share`: thin plate's flow at ratio() over its choked flow.
  N factor(const N& share, const N& r) const {
    return discharge(r) * power(larger(share, N(kLeastShare)), index_ - 1.0);
  }
  /// The same of choked flow, whose share is 1.
  N discharge(const N& r) const { return 1.0 + slope_ * (kThinPlateCritical - r); }

 private:
  /// Below it the flow is straight in the share.
  static constexpr double kLeastShare = 1e-6;
  struct Port {
    N critical{}, stretch{};
  };
  Port ports_[2];  ///< inlet, exhaust
  N index_{}, slope_{};
};

}  // namespace plenum::host::effects
