// chamber_leak: air leaves the chamber past its seals.
//
//   m = G (p^2 - P_a^2) / (2 P_a)
//
// p chamber, P_a ambient [Pa]; G conductance of a laminar gap at ambient density [kg/(s Pa)]. Assumptions:
// isothermal laminar gap flow. Vanishes at G = 0. A leak through a hole, with the flow function of the ports, adds
// to the exhaust's area at every command: that is an L_r and a threshold u_r that are larger, and calibration takes it.
// Source: compressible Poiseuille flow; leak curves of plastic and metal parts.
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 1> kChamberLeakParameters{{
    {"conductance_g_s_MPa", "of the gap, at ambient density", 0.0, 20.0, 0.0, 0.02, Coordinate::linear, false,
     kAsTheValve},
}};
inline constexpr Effect kChamberLeak{"chamber_leak",
                                     Equation::mass_flow,
                                     "air leaves the chamber through a narrow gap, whatever the valve does",
                                     "m = G (p^2 - P_a^2)/(2 P_a)",
                                     "laminar gap flow",
                                     kChamberLeakParameters};

template <class N>
class ChamberLeak {
 public:
  void prepare(const N* x, const N& ambient_Pa) {
    ambient_Pa_ = ambient_Pa;
    per_square_ = x[0] * 1e-9 / (2.0 * ambient_Pa);
  }
  N flow(const N& pressure_Pa) const {
    return per_square_ * (pressure_Pa * pressure_Pa - ambient_Pa_ * ambient_Pa_);
  }
  N slope(const N& pressure_Pa) const { return 2.0 * per_square_ * pressure_Pa; }

 private:
  N ambient_Pa_{}, per_square_{};
};

}  // namespace plenum::host::effects
