// tube_dynamics: a hose between valve and chamber holds air, resists it and must accelerate it.
//
//   (V/n) p_i'/(kappa R T) = w_(i-1) - w_i,   (L/(n A)) w_i' = p_i - p_(i+1) - r_i w_i,   V = A L,  A = pi D^2/4
//   n r = 128 mu L/(pi D^4 rho) + (f L/(D A^2) + 1/a^2) |w|/(2 rho) + R_f,   rho = (p_i + p_(i+1))/(2 R T)
//   p_1 = p_t, where (1 - c) V/n is filled by w_0 = m_v;  p_(n+1) = p;  the chamber holds c V/n more
//   the sensor reads  p + s (p_t - p)
//
// n = 3 sections; p_t pressure at the valve, p in the chamber [Pa]; m_v flow through the valve, w_i in section i
// [kg/s]; L length, D bore [m]; mu = 1.8e-5 Pa s viscosity, f = 0.03 friction factor of smooth hoses at Re about 1e4
// (Blasius); a effective area of the fittings [m2]; R_f resistance of a filter or of a line that is known by that
// alone [Pa s/kg]; s where the sensor sits: 0 in the chamber, 1 at the valve; c where the air of a section stands: 0
// at its upper end, 1/2 at both ends alike, as a line's does that is filled from one end through its own friction. At
// rest the friction is that of isothermal flow, p_t^2 - p^2 = 2 rho R T r w. Assumptions: sections, right below the
// line's first resonance a_0/(4 L), a_0 the speed of sound, 86 Hz for a metre (at c = 1/2 its first frequency is 1 %
// low, and a line of 4 m x 3 mm before 100 mL passes 3 Hz at full flow to 0.3 % where one lump errs by 2.6 %). (c
// refines: at 1/2 from the first a hose of some centimetres is found in a wrong place from most starts.) Vanishes at L
// = 0; a hose shorter than a millimetre is taken as one of a millimetre. Numerical treatment: all pressures and flows
// together by the third-order diagonally implicit Runge-Kutta rule of Alexander (SIAM J. Numer. Anal. 14, 1977),
// L-stable: a short hose is in equilibrium at any step. A stage is solved in two passes, friction and valve by one
// step of Newton's each: the friction's begins at flows that differ from those before by what the hose as one lump,
// whose friction is solved exactly, makes of the stage; the valve's at a chord to the pressure where its flow would
// end: where the flow is choked its slope is zero, and a narrow hose would be filled to many times the supply.
// (Linearly implicit Euler steps, extrapolated to third order, multiplied what a stage missed by four: a hose of 0.11
// m and 2 mm was wrong by 100 kPa.)
// Source: Richer and Hurmuzlu, J. Dyn. Sys. Meas. Control 122 (2000), a line in lumps.
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
    {"chamber_share", "c: of a section's air, what stands at its lower end", 0.0, 0.5, 0.0, 0.2,
     Coordinate::linear, true},
}};
inline constexpr Effect kTubeDynamics{"tube_dynamics",
                                      Equation::mass_flow,
                                      "a hose between valve and chamber: its volume, friction and inertia",
                                      "(V/3) p_i'/(kappa R T) = w_(i-1) - w_i, (L/(3 A)) w_i' = p_i - "
                                      "p_(i+1) - r(w_i) w_i, w_0 = m_v, read p + s (p_1 - p)",
                                      "Richer and Hurmuzlu (2000), three sections",
                                      kTubeDynamicsParameters};

template <class N>
class TubeDynamics {
 public:
  static constexpr std::size_t kSections = 3;
  static constexpr auto kParts = static_cast<double>(kSections);

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
    const N section_m3 = (1.0 / kParts) * area * length;
    at_chamber_m3_ = x[5] * section_m3;
    per_volume_ = kappa * gas_J_kg / (section_m3 - at_chamber_m3_);
    per_section_ = kappa * gas_J_kg / section_m3;
    per_inertia_ = kParts * area / length;
    laminar_ =
        (1.0 / kParts) * 128.0 * 1.8e-5 / std::numbers::pi * gas_J_kg * length / (bore * bore * bore * bore);
    turbulent_ = (1.0 / kParts) * gas_J_kg * 0.5 * (0.03 * length / (bore * area * area) + 1e12 * x[2]);
    straight_ = (1.0 / kParts) * 1e6 * x[3];
    read_at_valve_ = x[4];
    pressure_Pa_.fill(start_Pa);
    flow_kg_s_.fill(N(0.0));
  }

  const N& at_valve_Pa() const { return pressure_Pa_.front(); }
  /// Into the chamber.
  const N& flow_kg_s() const { return flow_kg_s_.back(); }
  /// Of its air, what swells the chamber.
  const N& at_chamber_m3() const { return at_chamber_m3_; }
  /// Where the sensor sits, the chamber being at `chamber_Pa`.
  N read_Pa(const N& chamber_Pa) const { return chamber_Pa + read_at_valve_ * (at_valve_Pa() - chamber_Pa); }

  /// The pressures at which the flow into the hose ends, and that out of it.
  struct Ends {
    N least_Pa, most_Pa;
  };

  /// So large a part of a step. `valve(p_t, share)` gives {rate, slope}: the flow through the valve and its slope; of the
  /// mean flow this one is so large a share.
  template <class ValveFlow>
  Step advance(const N& chamber_Pa, const Chamber& chamber, const Ends& ends, const ValveFlow& valve,
               const N& part = N(1.0)) {
    const N span_s = larger(step_s_ * part, N(1e-7));  // a part may be empty
    constexpr double kFirst = (-6.0 * kGamma * kGamma + 16.0 * kGamma - 1.0) / 4.0;
    constexpr double kSecond = (6.0 * kGamma * kGamma - 20.0 * kGamma + 5.0) / 4.0;
    const State begin{pressure_Pa_, flow_kg_s_, chamber_Pa};
    const N most_Pa = larger(ends.most_Pa, at_valve_Pa());

    const auto now = valve(at_valve_Pa(), 0.0);
    const N room_Pa = select(now.rate > N(0.0), ends.most_Pa - at_valve_Pa(), at_valve_Pa() - ends.least_Pa);
    Line line{at_valve_Pa(), now.rate, smaller(now.slope, -magnitude(now.rate) / larger(room_Pa, N(1e3)))};
    const Common by = common(kGamma * span_s, chamber);
    const auto stage = [&](const State& from, const State& near, double share) {
      PerSection thinness = thinness_of(near);
      const N as_lump = lump(by, from, line, thinness);
      const State guess = implicit(by, from, shifted(near.w, as_lump - mean_of(near.w)), line, thinness);
      thinness = thinness_of(guess);
      const N at_Pa = smaller(guess.p[0], most_Pa);
      const auto there = valve(at_Pa, share);
      line = {at_Pa, there.rate, there.slope};
      return implicit(by, from, shifted(guess.w, lump(by, from, line, thinness) - as_lump), line, thinness);
    };
    const State y1 = stage(begin, begin, kFirst);
    const State k1 = sum(y1, -1.0, begin);  // gamma h times the rate
    const State from2 = sum(begin, 0.5 * (1.0 - kGamma) / kGamma, k1);
    const State y2 = stage(from2, y1, kSecond);
    const State k2 = sum(y2, -1.0, from2);
    const State end = stage(sum(sum(begin, kFirst / kGamma, k1), kSecond / kGamma, k2), y2, kGamma);

    const auto rate = [&](const State& at) {
      return chamber.per_flow * at.w.back() + chamber.constant - chamber.decay_1_s * at.chamber;
    };
    pressure_Pa_ = end.p;
    flow_kg_s_ = end.w;
    const N mean = 0.5 * (chamber_Pa + end.chamber) + span_s * (1.0 / 12.0) * (rate(begin) - rate(end));
    const N mean_at_valve = kFirst * y1.p[0] + kSecond * y2.p[0] + kGamma * end.p[0];
    return {end.chamber, mean, mean + read_at_valve_ * (mean_at_valve - mean)};
  }

 private:
  static constexpr double kGamma = 0.435866521508459;  ///< root of 1/6 - 3/2 g + 3 g^2 - g^3
  using PerSection = std::array<N, kSections>;
  /// At the upper ends of the sections, in them, and in the chamber.
  struct State {
    PerSection p, w;
    N chamber;
  };
  /// The flow through the valve near a pressure.
  struct Line {
    N at_Pa, rate, slope;
  };

  /// What all stages of a step have in common, over gamma h.
  struct Common {
    N added, kept;           ///< a chamber without flow goes from p to (p + added) kept
    N gained;                ///< by the chamber, for a flow of 1 kg/s
    N push;                  ///< flow for a pascal across a section
    N fill, first_fill;      ///< pressure for a flow of 1 kg/s into an inner node and into that at the valve
    N per_fill;              ///< 1/fill
    N fill_lump, push_lump;  ///< of the hose as one lump
  };

  Common common(const N& h, const Chamber& chamber) const {
    const N kept = 1.0 / (1.0 + h * chamber.decay_1_s);
    return {.added = h * chamber.constant,
            .kept = kept,
            .gained = h * chamber.per_flow * kept,
            .push = h * per_inertia_,
            .fill = h * per_section_,
            .first_fill = h * per_volume_,
            .per_fill = 1.0 / (h * per_section_),
            .fill_lump = h * (1.0 / kParts) * per_section_,
            .push_lump = h * (1.0 / kParts) * per_inertia_};
  }

  static State sum(const State& a, double k, const State& b) {
    State r;
    for (std::size_t i = 0; i < kSections; ++i) {
      r.p[i] = a.p[i] + k * b.p[i];
      r.w[i] = a.w[i] + k * b.w[i];
    }
    r.chamber = a.chamber + k * b.chamber;
    return r;
  }
  static N mean_of(const PerSection& all) {
    N sum = all[0];
    for (std::size_t i = 1; i < kSections; ++i) sum += all[i];
    return (1.0 / kParts) * sum;
  }
  static PerSection shifted(PerSection flows, const N& by_kg_s) {
    for (N& w : flows) w += by_kg_s;
    return flows;
  }
  /// One over the mean pressures.
  static PerSection thinness_of(const State& at) {
    PerSection r;
    for (std::size_t i = 0; i < kSections; ++i) {
      r[i] = 2.0 / (at.p[i] + (i + 1 < kSections ? at.p[i + 1] : at.chamber));
    }
    return r;
  }

  /// The flow through the hose after a stage as it would be in one lump, its friction solved exactly.
  N lump(const Common& by, const State& from, const Line& valve, const PerSection& thinness) const {
    const N thin = mean_of(thinness);
    // linear w + square |w| w = driven, all times what the slope of the valve's flow makes of the pressure there
    const N held = 1.0 - by.fill_lump * valve.slope;
    const N free_t = from.p[0] + by.fill_lump * (valve.rate - valve.slope * valve.at_Pa);
    const N free_p = (from.chamber + by.added) * by.kept;
    const N linear =
        held + by.push_lump * (by.fill_lump + held * (by.gained + kParts * (laminar_ * thin + straight_)));
    const N square = held * by.push_lump * kParts * turbulent_ * thin;
    const N driven = held * mean_of(from.w) + by.push_lump * (free_t - held * free_p);
    return 2.0 * driven / (linear + root(linear * linear + 4.0 * square * magnitude(driven)));
  }

  /// A stage: y = from + gamma h f(y), the friction's square by its tangent at the flows `near`. From the chamber up: behind a
  /// section stands free + gained w, and its own flow obeys linear w = driven + push p, p being the pressure above it.
  State implicit(const Common& by, const State& from, const PerSection& near, const Line& valve,
                 const PerSection& thinness) const {
    PerSection free, gained;
    free.back() = (from.chamber + by.added) * by.kept;
    gained.back() = by.gained;
    const auto section = [&](std::size_t i, N& linear, N& driven) {
      const N chord = by.push * turbulent_ * thinness[i] * magnitude(near[i]);
      linear = 1.0 + by.push * (gained[i] + laminar_ * thinness[i] + straight_) + 2.0 * chord;
      driven = from.w[i] + chord * near[i] - by.push * free[i];
    };
    N linear, driven;
    for (std::size_t i = kSections - 1; i > 0; --i) {
      section(i, linear, driven);
      const N each = 1.0 / (linear + by.fill * by.push);
      free[i - 1] = (linear * from.p[i] - by.fill * driven) * each;
      gained[i - 1] = by.fill * linear * each;
    }
    section(0, linear, driven);
    const N free_t = from.p[0] + by.first_fill * (valve.rate - valve.slope * valve.at_Pa);
    const N held = 1.0 - by.first_fill * valve.slope;
    const N each = 1.0 / (held * linear + by.first_fill * by.push);
    State to;
    to.w[0] = (held * driven + by.push * free_t) * each;
    to.p[0] = larger((linear * free_t - by.first_fill * driven) * each, N(1e3));
    for (std::size_t i = 0; i < kSections; ++i) {
      const N p = free[i] + gained[i] * to.w[i];
      if (i + 1 < kSections) {
        to.w[i + 1] = to.w[i] + by.per_fill * (from.p[i + 1] - p);
        to.p[i + 1] = larger(p, N(1e3));
      } else {
        to.chamber = larger(p, N(1e3));
      }
    }
    return to;
  }

  N at_chamber_m3_{}, per_volume_{}, per_section_{}, per_inertia_{}, laminar_{}, turbulent_{}, straight_{},
      read_at_valve_{};
  PerSection pressure_Pa_{}, flow_kg_s_{};  ///< at the upper ends of the sections, in them
  double step_s_ = 0.0;
};

}  // namespace plenum::host::effects
