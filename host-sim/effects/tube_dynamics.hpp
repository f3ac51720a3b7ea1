// tube_dynamics: a hose between valve and chamber holds air, resists it and must accelerate it.
//
//   V p_t'/(kappa R T) = m_v - w,   (L/A) w' = p_t - p - r w,   V = A L,  A = pi D^2/4
//   r = 128 mu L/(pi D^4 rho) + f L |w|/(2 D rho A^2),   rho = (p_t + p)/(2 R T)
//
// p_t pressure at the valve, p in the chamber [Pa]; m_v flow through the valve, w into the chamber [kg/s]; L length,
// D bore [m]; mu = 1.8e-5 Pa s viscosity, f = 0.03 friction factor of smooth hoses at Re about 1e4 (Blasius). At rest
// the friction is that of isothermal flow, p_t^2 - p^2 = 2 rho R T r w. Assumptions: one lump, right below a line's
// first resonance c/(4 L), 86 Hz for a metre; the lump's own is c/(2 pi L). (Half of V in the chamber would bring it to
// c/(sqrt(2) pi L), but a hose of some centimetres is then found in a wrong place from most starts.) Vanishes at L = 0;
// a hose shorter than a millimetre is taken as one of a millimetre. Numerical treatment: p_t,
// w and the chamber's p together by the linearly implicit Euler rule in one, two and three parts of the step,
// extrapolated to third order: stiffly stable, and no stage overshoots, so that a short hose is in equilibrium at any
// step. (The inner stage of a Rosenbrock rule of two overshoots 2.4 times where a command jumps; a hose of 2 mm
// then left the range of numbers.) Source: lumped line of Richer and Hurmuzlu, J. Dyn. Sys. Meas. Control 122 (2000).
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
    N end_Pa, mean_Pa;
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

  const N& at_valve_Pa() const { return at_valve_Pa_; }
  const N& flow_kg_s() const { return flow_kg_s_; }

  /// One step. `valve(p_t)` gives {rate, slope}: the flow through the valve and its slope. Its last two calls are at
  /// the step's thirds.
  template <class ValveFlow>
  Step advance(const N& chamber_Pa, const Chamber& chamber, const ValveFlow& valve) {
    constexpr std::array<double, 3> kWeight{0.5, -4.0, 4.5};  // of the step in one, two and three parts
    const State begin{at_valve_Pa_, flow_kg_s_, chamber_Pa};
    const auto first = valve(at_valve_Pa_);
    State end{};
    for (int parts = 1; parts <= 3; ++parts) {
      State y = implicit(begin, first, chamber, step_s_ / parts);
      for (int part = 1; part < parts; ++part) y = implicit(y, valve(y.p_t), chamber, step_s_ / parts);
      const double weight = kWeight[static_cast<std::size_t>(parts - 1)];
      end.p_t += weight * y.p_t;
      end.w += weight * y.w;
      end.p += weight * y.p;
    }
    at_valve_Pa_ = larger(end.p_t, N(1e3));
    flow_kg_s_ = end.w;
    const N end_Pa = larger(end.p, N(1e3));
    const auto rate = [&](const N& w, const N& p) {
      return chamber.per_flow * w + chamber.constant - chamber.decay_1_s * p;
    };
    const N mean_Pa =
        0.5 * (chamber_Pa + end_Pa) + step_s_ / 12.0 * (rate(begin.w, chamber_Pa) - rate(flow_kg_s_, end_Pa));
    return {end_Pa, mean_Pa};
  }

 private:
  struct State {
    N p_t, w, p;
  };

  /// A step `h` of the linearly implicit Euler rule; its matrix 1 - h J is tridiagonal.
  template <class Flow>
  State implicit(const State& y, const Flow& valve, const Chamber& chamber, double h) const {
    const N per_mean = 2.0 / (y.p_t + y.p);
    const N turbulent = turbulent_ * magnitude(y.w) * per_mean;
    const N friction = laminar_ * per_mean + turbulent;
    const N b1 = h * per_volume_ * (valve.rate - y.w);
    const N b2 = h * per_inertia_ * (y.p_t - y.p - friction * y.w);
    const N b3 = h * (chamber.per_flow * y.w + chamber.constant - chamber.decay_1_s * y.p);
    const N a11 = 1.0 - h * per_volume_ * valve.slope;
    const N a12 = h * per_volume_;
    const N a23 = h * per_inertia_;  // and -a21
    const N a22 = 1.0 + a23 * (friction + turbulent);
    const N a32 = -h * chamber.per_flow;
    const N a33 = 1.0 + h * chamber.decay_1_s;
    const N d11 = 1.0 / a11;
    const N d33 = 1.0 / a33;
    const N w = (b2 + a23 * (d11 * b1 - d33 * b3)) / (a22 + a23 * (a12 * d11 - a32 * d33));
    return {larger(y.p_t + (b1 - a12 * w) * d11, N(1e3)), y.w + w,
            larger(y.p + (b3 - a32 * w) * d33, N(1e3))};
  }

  N per_volume_{}, per_inertia_{}, laminar_{}, turbulent_{};
  N at_valve_Pa_{}, flow_kg_s_{};
  double step_s_ = 0.0;
};

}  // namespace plenum::host::effects
