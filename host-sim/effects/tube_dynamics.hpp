// tube_dynamics: a hose between valve and chamber holds air, resists it and must accelerate it.
//
//   (1 - c) V p_t'/(kappa R T) = m_v - w,   (L/A) w' = p_t - p - r w,   V = A L,  A = pi D^2/4
//   r = 128 mu L/(pi D^4 rho) + (f L/(D A^2) + 1/a^2) |w|/(2 rho) + R_f,   rho = (p_t + p)/(2 R T)
//   the chamber holds c V more;  the sensor reads  p + s (p_t - p)
//
// p_t pressure at the valve, p in the chamber [Pa]; m_v flow through the valve, w into the chamber [kg/s]; L length, D bore
// [m]; mu = 1.8e-5 Pa s viscosity, f = 0.03 friction factor of smooth hoses at Re about 1e4 (Blasius); a effective area of
// the fittings [m2]; R_f resistance of a filter or of a line that is known by that alone [Pa s/kg]; s where the sensor
// sits: 0 in the chamber, 1 at the valve; c where its air stands: 0 at the valve, 1/2 at both ends alike, as a line's does that is
// filled from one end through its own friction. At rest the friction is that of isothermal flow, p_t^2 - p^2 = 2 rho R T r w.
// Assumptions: one lump, right below a line's first resonance a_0/(4 L), a_0 the speed of sound, 86 Hz for a metre; the lump's own is
// a_0/(2 pi L), at c = 1/2 a_0/(sqrt(2) pi L). (c refines: at 1/2 from the first a hose of some centimetres is found in a wrong
// place from most starts.) Vanishes at L = 0; a hose shorter than a millimetre is taken as one of a millimetre. Numerical
// treatment: p_t, w and the chamber's p together by the third-order diagonally implicit Runge-Kutta rule of Alexander (SIAM
// J. Numer. Anal. 14, 1977), L-stable: a short hose is in equilibrium at any step. In a stage the friction's square is
// solved exactly and the flow through the valve by one step of Newton's, which begins at a chord to the pressure where that
// flow would end: where the flow is choked its slope is zero, and a narrow hose would be filled to many times the supply.
// (Linearly implicit Euler steps, extrapolated to third order, multiplied what a stage missed by four: a hose of 0.11 m and
// 2 mm was wrong by 100 kPa.) Source: lumped line of Richer and Hurmuzlu, J. Dyn. Sys. Meas. Control 122 (2000).
#pragma once

#include <array>
#include <numbers>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 6> kTubeDynamicsParameters{{
    {"length_m", "of the hose", 0.0, 15.0, 0.0, 0.3},
    {"bore_mm", "its inner diameter", 1.5, 12.0, 4.0, 0.5, Coordinate::linear, false, kAsItsDiameter},
    {"fittings_mm2", "a: effective area of what is narrow on the way", 0.1, kInfinity, kInfinity, 0.02,
     Coordinate::reciprocal_square, true, kAsTheValve},
    {"resistance_kPa_s_per_g", "R_f: of a filter", 0.0, 400.0, 0.0, 5.0, Coordinate::linear, true,
     kAsItsResistance},
    {"sensor_share", "s: of the way from chamber to valve at which the sensor sits", 0.0, 1.0, 0.0, 0.2,
     Coordinate::linear, true},
    {"chamber_share", "c: of its air, what stands at the chamber's end", 0.0, 0.5, 0.0, 0.2,
     Coordinate::linear, true},
}};
inline constexpr Effect kTubeDynamics{
    "tube_dynamics",
    Equation::mass_flow,
    "a hose between valve and chamber: its volume, friction and inertia",
    "(1 - c) V p_t'/(kappa R T) = m_v - w, (L/A) w' = p_t - p - r(w) w, read p + s (p_t - p)",
    "Richer and Hurmuzlu (2000), one lump",
    kTubeDynamicsParameters};

template <class N>
class TubeDynamics {
 public:
  /// The chamber's part, linear in its pressure: p' = per_flow w + constant - decay p.
  struct Chamber {
    N per_flow, constant, decay_1_s;
  };
  /// What a step found: the chamber's pressure at its end and in the mean, and the mean where the sensor sits.
  struct Step {
    N end_Pa, mean_Pa, mean_read_Pa;
  };

  /// `gas_J_kg`: R T.
  void prepare(const N* x, double gas_J_kg, double kappa, double step_s, const N& start_Pa) {
    const N length = larger(x[0], N(1e-3));
    const N bore = x[1] * 1e-3;
    const N area = std::numbers::pi / 4.0 * bore * bore;
    step_s_ = step_s;
    at_chamber_m3_ = x[5] * area * length;
    per_volume_ = kappa * gas_J_kg / (area * length - at_chamber_m3_);
    per_inertia_ = area / length;
    laminar_ = 128.0 * 1.8e-5 / std::numbers::pi * gas_J_kg * length / (bore * bore * bore * bore);
    turbulent_ = gas_J_kg * 0.5 * (0.03 * length / (bore * area * area) + 1e12 * x[2]);
    straight_ = 1e6 * x[3];
    read_at_valve_ = x[4];
    at_valve_Pa_ = start_Pa;
    flow_kg_s_ = N(0.0);
  }

  const N& at_valve_Pa() const { return at_valve_Pa_; }
  const N& flow_kg_s() const { return flow_kg_s_; }
  /// Of its air, what swells the chamber.
  const N& at_chamber_m3() const { return at_chamber_m3_; }
  /// Where the sensor sits, the chamber being at `chamber_Pa`.
  N read_Pa(const N& chamber_Pa) const { return chamber_Pa + read_at_valve_ * (at_valve_Pa_ - chamber_Pa); }

  /// The pressures at which the flow into the hose ends, and that out of it.
  struct Ends {
    N least_Pa, most_Pa;
  };

  /// So large a part of a step. `valve(p_t, share)` gives {rate, slope}: the flow through the valve and its slope; of the
  /// mean flow this one is so large a share.
  template <class ValveFlow>
  Step advance(const N& chamber_Pa, const Chamber& chamber, const Ends& ends, const ValveFlow& valve,
               const N& part = N(1.0)) {
    const N span_s = step_s_ * part;
    constexpr double kFirst = (-6.0 * kGamma * kGamma + 16.0 * kGamma - 1.0) / 4.0;
    constexpr double kSecond = (6.0 * kGamma * kGamma - 20.0 * kGamma + 5.0) / 4.0;
    const State begin{at_valve_Pa_, flow_kg_s_, chamber_Pa};
    const N most_Pa = larger(ends.most_Pa, at_valve_Pa_);

    const auto now = valve(at_valve_Pa_, 0.0);
    const N room_Pa = select(now.rate > N(0.0), ends.most_Pa - at_valve_Pa_, at_valve_Pa_ - ends.least_Pa);
    Line line{at_valve_Pa_, now.rate, smaller(now.slope, -magnitude(now.rate) / larger(room_Pa, N(1e3)))};
    const auto stage = [&](const State& from, const N& near_Pa, double share) {
      const State guess = implicit(span_s, from, near_Pa, line, chamber);
      const N at_Pa = smaller(guess.p_t, most_Pa);
      const auto there = valve(at_Pa, share);
      line = {at_Pa, there.rate, there.slope};
      return implicit(span_s, from, guess.p, line, chamber);
    };
    const State y1 = stage(begin, chamber_Pa, kFirst);
    const State k1 = sum(y1, -1.0, begin);  // gamma h times the rate
    const State from2 = sum(begin, 0.5 * (1.0 - kGamma) / kGamma, k1);
    const State y2 = stage(from2, y1.p, kSecond);
    const State k2 = sum(y2, -1.0, from2);
    const State end = stage(sum(sum(begin, kFirst / kGamma, k1), kSecond / kGamma, k2), y2.p, kGamma);

    const auto rate = [&](const State& at) {
      return chamber.per_flow * at.w + chamber.constant - chamber.decay_1_s * at.p;
    };
    at_valve_Pa_ = end.p_t;
    flow_kg_s_ = end.w;
    const N mean = 0.5 * (chamber_Pa + end.p) + span_s * (1.0 / 12.0) * (rate(begin) - rate(end));
    const N mean_at_valve = kFirst * y1.p_t + kSecond * y2.p_t + kGamma * end.p_t;
    return {end.p, mean, mean + read_at_valve_ * (mean_at_valve - mean)};
  }

 private:
  static constexpr double kGamma = 0.435866521508459;  ///< root of 1/6 - 3/2 g + 3 g^2 - g^3
  struct State {
    N p_t, w, p;
  };
  /// The flow through the valve near a pressure.
  struct Line {
    N at_Pa, rate, slope;
  };

  static State sum(const State& a, double k, const State& b) {
    return {a.p_t + k * b.p_t, a.w + k * b.w, a.p + k * b.p};
  }

  /// A stage: y = from + gamma h f(y), h the span, the friction at the density between valve and `near_Pa`.
  State implicit(const N& span_s, const State& from, const N& near_Pa, const Line& valve,
                 const Chamber& chamber) const {
    const N h = kGamma * span_s;
    const N per_mean = 2.0 / (valve.at_Pa + near_Pa);
    const N d_t = 1.0 / (1.0 - h * per_volume_ * valve.slope);
    const N d_p = 1.0 / (1.0 + h * chamber.decay_1_s);
    // what the pressures would be without flow between them, and what each loses and gains by it
    const N free_t = (from.p_t + h * per_volume_ * (valve.rate - valve.slope * valve.at_Pa)) * d_t;
    const N free_p = (from.p + h * chamber.constant) * d_p;
    const N lost = h * per_volume_ * d_t;
    const N gained = h * chamber.per_flow * d_p;
    // linear w + square |w| w = driven
    const N linear = 1.0 + h * per_inertia_ * (lost + gained + laminar_ * per_mean + straight_);
    const N square = h * per_inertia_ * turbulent_ * per_mean;
    const N driven = from.w + h * per_inertia_ * (free_t - free_p);
    const N w = 2.0 * driven / (linear + root(linear * linear + 4.0 * square * magnitude(driven)));
    return {larger(free_t - lost * w, N(1e3)), w, larger(free_p + gained * w, N(1e3))};
  }

  N at_chamber_m3_{}, per_volume_{}, per_inertia_{}, laminar_{}, turbulent_{}, straight_{}, read_at_valve_{};
  N at_valve_Pa_{}, flow_kg_s_{};
  double step_s_ = 0.0;
};

}  // namespace plenum::host::effects
