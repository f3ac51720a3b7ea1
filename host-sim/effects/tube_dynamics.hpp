// tube_dynamics: a hose between valve and chamber holds air, resists it and must accelerate it.
//
//   V p_t'/(kappa R T) = m_v - w,   (L/A) w' = p_t - p - r w,   V = A L,  A = pi D^2/4
//   r = 128 mu L/(pi D^4 rho) + f L |w|/(2 D rho A^2),   rho = p/(R T)
//
// p_t pressure at the valve, p in the chamber [Pa]; m_v flow through the valve, w into the chamber [kg/s]; L length,
// D bore [m]; mu = 1.8e-5 Pa s viscosity, f = 0.03 friction factor of smooth hoses at Re about 1e4 (Blasius).
// Assumptions: one lump, right below its first resonance c/(4 L): 86 Hz for a metre. Vanishes at L = 0. Numerical
// treatment: p_t, w and the chamber's p together by a Rosenbrock rule of two stages, second order and L-stable
// (Verwer's ROS2, gamma = 1 - 1/sqrt 2), so that a short hose is in equilibrium at any step; its matrix is
// tridiagonal. Source: lumped line of Richer and Hurmuzlu, J. Dyn. Sys. Meas. Control 122 (2000).
#pragma once

#include <array>
#include <numbers>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kTubeDynamicsParameters{{
    {"length_m", "of the hose", 0.0, 15.0, 0.0, 0.3},
    {"bore_mm", "its inner diameter", 1.5, 12.0, 4.0, 0.5},
}};
inline constexpr Effect kTubeDynamics{"tube_dynamics",
                                      Equation::mass_flow,
                                      "a hose between valve and chamber: its volume, friction and inertia",
                                      "V p_t'/(kappa R T) = m_v - w, (L/A) w' = p_t - p - r(w) w",
                                      "Richer and Hurmuzlu (2000), one lump",
                                      kTubeDynamicsParameters};

template <class N>
class TubeDynamics {
 public:
  /// The chamber's part, linear in its pressure: p' = per_flow w + constant - decay p.
  struct Chamber {
    N per_flow, constant, decay_1_s;
  };
  /// What a step found: the chamber's pressure at its end and in the mean.
  struct Step {
    N end_Pa, mean_Pa, mean_flow_kg_s;
  };

  /// `gas_J_kg`: R T.
  void prepare(const N* x, double gas_J_kg, double kappa, double step_s, const N& start_Pa) {
    const N length = larger(x[0], N(1e-3));
    const N bore = x[1] * 1e-3;
    const N area = std::numbers::pi / 4.0 * bore * bore;
    step_s_ = step_s;
    per_volume_ = kappa * gas_J_kg / (area * length);
    per_inertia_ = area / length;
    laminar_ = 128.0 * 1.8e-5 / std::numbers::pi * gas_J_kg * length / (bore * bore * bore * bore);
    turbulent_ = 0.03 * gas_J_kg * 0.5 * length / (bore * area * area);
    at_valve_Pa_ = start_Pa;
    flow_kg_s_ = N(0.0);
  }

  /// One step. `valve(p_t)` gives {rate, slope}: the flow through the valve and its slope.
  template <class ValveFlow>
  Step advance(const N& chamber_Pa, const Chamber& chamber, const ValveFlow& valve) {
    constexpr double kGamma = 0.2928932188134524;  // 1 - 1/sqrt 2
    const double gh = kGamma * step_s_;
    const N density_1 = 1.0 / chamber_Pa;
    const N friction = (laminar_ + turbulent_ * magnitude(flow_kg_s_)) * density_1;
    const auto first = valve(at_valve_Pa_);
    const State f1{per_volume_ * (first.rate - flow_kg_s_),
                   per_inertia_ * (at_valve_Pa_ - chamber_Pa - friction * flow_kg_s_),
                   chamber.per_flow * flow_kg_s_ + chamber.constant - chamber.decay_1_s * chamber_Pa};
    // 1 - gamma h J, tridiagonal
    const N a11 = 1.0 - gh * per_volume_ * first.slope;
    const N a12 = gh * per_volume_;
    const N a21 = -gh * per_inertia_;
    const N a22 = 1.0 + gh * per_inertia_ * (friction + turbulent_ * magnitude(flow_kg_s_) * density_1);
    const N a23 = gh * per_inertia_;
    const N a32 = -gh * chamber.per_flow;
    const N a33 = 1.0 + gh * chamber.decay_1_s;
    const N d11 = 1.0 / a11;
    const N d33 = 1.0 / a33;
    const N d22 = 1.0 / (a22 - a21 * a12 * d11 - a23 * a32 * d33);
    const auto solve = [&](const State& b) {
      const N w = (b.w - a21 * d11 * b.p_t - a23 * d33 * b.p) * d22;
      return State{(b.p_t - a12 * w) * d11, w, (b.p - a32 * w) * d33};
    };
    const State k1 = solve(f1);
    const State y{larger(at_valve_Pa_ + step_s_ * k1.p_t, N(1e3)), flow_kg_s_ + step_s_ * k1.w,
                  larger(chamber_Pa + step_s_ * k1.p, N(1e3))};
    const N friction_2 = (laminar_ + turbulent_ * magnitude(y.w)) / y.p;
    const auto second = valve(y.p_t);
    const State k2 =
        solve({per_volume_ * (second.rate - y.w) - 2.0 * k1.p_t,
               per_inertia_ * (y.p_t - y.p - friction_2 * y.w) - 2.0 * k1.w,
               chamber.per_flow * y.w + chamber.constant - chamber.decay_1_s * y.p - 2.0 * k1.p});
    at_valve_Pa_ = larger(at_valve_Pa_ + step_s_ * (1.5 * k1.p_t + 0.5 * k2.p_t), N(1e3));
    const N flow_before = flow_kg_s_;
    flow_kg_s_ += step_s_ * (1.5 * k1.w + 0.5 * k2.w);
    const N end = larger(chamber_Pa + step_s_ * (1.5 * k1.p + 0.5 * k2.p), N(1e3));
    const N rate_end = chamber.per_flow * flow_kg_s_ + chamber.constant - chamber.decay_1_s * end;
    return {end, 0.5 * (chamber_Pa + end) + step_s_ / 12.0 * (f1.p - rate_end),
            0.5 * (flow_before + flow_kg_s_)};
  }

 private:
  struct State {
    N p_t, w, p;
  };
  N per_volume_{}, per_inertia_{}, laminar_{}, turbulent_{};
  N at_valve_Pa_{}, flow_kg_s_{};
  double step_s_ = 0.0;
};

}  // namespace plenum::host::effects
