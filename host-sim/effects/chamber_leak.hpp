// chamber_leak: air leaves the chamber past its seals.
//
//   m = G (v/v_0)^e (p - P) (1 + d (p - P)/(2 P)),   P = P_a + t,   which is  G (p^2 - P_a^2)/(2 P_a)  with d = 1, e = t = 0
//
// p chamber, P where it leaks to, P_a ambient [Pa]; t what is beyond ambient there [Pa]: past a piston's seal, the pressure of a
// cylinder's other side, from which air comes where that is the higher one; v volume, v_0 its mean over the first log [m3]; G conductance of a laminar gap at ambient
// density [kg/(s Pa)]; d share of the gas's density in it: 1 in a gap, 0 a flow straight in the gauge pressure, between that of
// a gap and that of a hole; e how the gap grows along the stroke, as in a worn bore. Assumptions: isothermal laminar gap flow;
// v from v_0/20 to 20 v_0; v_0 is not kept with the figures, so that a rig which is saved with e is one of logs of the same mean
// volume. Vanishes at G = 0. A leak through a hole, with the flow function of the ports, adds to the exhaust's area at every
// command: that is an L_r and a threshold u_r that are larger, and calibration takes it. Source: compressible Poiseuille flow;
// leak curves of plastic and metal parts.
#pragma once

#include <algorithm>
#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 4> kChamberLeakParameters{{
    {"conductance_g_s_MPa", "of the gap, at ambient density", 0.0, 20.0, 0.0, 0.02, Coordinate::linear, false,
     kAsTheValve},
    {"density_share", "d: 1 laminar, 0 straight in the gauge pressure", 0.0, 1.0, 1.0, 0.2,
     Coordinate::linear, true},
    {"volume_power", "e: the gap grows as v^e", -1.0, 3.0, 0.0, 0.3, Coordinate::linear, true},
    {"beyond_kPa", "t: above ambient where it leaks to, as past a piston", 0.0, 1500.0, 0.0, 20.0,
     Coordinate::linear, true},
}};
inline constexpr Effect kChamberLeak{"chamber_leak",
                                     Equation::mass_flow,
                                     "air leaves the chamber through a narrow gap, whatever the valve does",
                                     "m = G (v/v_0)^e (p - P) (1 + d (p - P)/(2 P)), P = P_a + t",
                                     "laminar gap flow",
                                     kChamberLeakParameters};

template <class N>
class ChamberLeak {
 public:
  void prepare(const N* x, const N& ambient_Pa, double mean_volume_m3, double volume_m3) {
    beyond_Pa_ = ambient_Pa + 1e3 * x[3];
    conductance_ = x[0] * 1e-9;
    per_gauge_ = x[1] * (0.5 / beyond_Pa_);
    power_ = x[2];
    per_mean_1_m3_ = 1.0 / mean_volume_m3;
    at(volume_m3);
  }
  /// The chamber has this volume now.
  void at(double volume_m3) {
    now_ = conductance_ * power(N(std::clamp(volume_m3 * per_mean_1_m3_, 0.05, 20.0)), power_);
  }
  N flow(const N& pressure_Pa) const {
    const N gauge = pressure_Pa - beyond_Pa_;
    return now_ * gauge * (1.0 + per_gauge_ * gauge);
  }
  N slope(const N& pressure_Pa) const { return now_ * (1.0 + 2.0 * per_gauge_ * (pressure_Pa - beyond_Pa_)); }

 private:
  N beyond_Pa_{}, conductance_{}, per_gauge_{}, power_{}, now_{};
  double per_mean_1_m3_ = 0.0;
};

}  // namespace plenum::host::effects
