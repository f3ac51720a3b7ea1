// heat_transfer: the walls take heat from the gas, so that it is not compressed adiabatically.
//
//   p' = n (R T_0 (m_c - m_r)/v - p v'/v) - (p - m R T_0/v)/tau,    tau = c_v m/(h A),   m' = m_c - m_r
//   h A = G (p/P_a)^a (v + e)/(100 mL)
//   where c > 0:  m_r (T/T_0)^(c/2) in p', m_r (T_0/T)^(c/2) in m',  T = p v/(m R)
//
// p [Pa], v [m3], m mass of the gas [kg], T_0 wall [K], c_v = R/(kappa - 1); G conductance to the wall [W/K] at ambient
// pressure P_a for each 100 mL of a cylinder, whose sides are 4 v/D; a how it grows with the density [-]; e what its two
// ends add, pi D^3/8 [m3]; n exponent [-]; c how much of the gas's own temperature leaves by the exhaust port: 0 at T_0, as
// in (4), 1 all of it, by which an orifice passes less mass, that of T^-1/2, and more enthalpy, that of T^1/2. a is 1/2 for
// laminar natural convection (Gr^1/4) and for engines (Eichelberg), 2/3 for turbulent natural convection (Gr^1/3), 0.8 in
// forced flow (Re^0.8). Assumptions: what leaves by a leak or a hose does so at T_0; wall of one temperature; gas at most
// four times as hot as the wall, and as cold: what leaves at T_0 has not the gas's own enthalpy, so that mass and energy
// would part without end behind a wall that hardly conducts; filling from a vacuum and compression by 20 together make a
// factor of 3.3. Range: p from P_a/20 to 20 P_a. Vanishes at G = c = 0 with n = kappa, exactly (4); G -> infinity is the
// isothermal chamber. Numerical treatment: the relaxation enters rate and slope of the step, with the mass expected at its
// middle; m then moves by the mass that the step's own balance of energy has moved. Source: "Electropneumatic servo"
// (13)-(21); Eichelberg, Engineering 148 (1939); Carneiro and de Almeida, Proc. IMechE I 221 (2007).
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 5> kHeatTransferParameters{{
    {"conductance_W_K", "h A to the wall, at ambient pressure, for each 100 mL", 0.0, 50.0, 0.0, 0.03},
    {"exponent", "n: 1.4 adiabatic, 1 isothermal", 1.0, 1.4, 1.4, 0.05, Coordinate::linear, true},
    {"pressure_power", "a: h A grows as p^a", 0.0, 1.2, 0.5, 0.2},
    {"ends_mL", "e: the volume of which the sides are as large as the ends", 0.0, 2000.0, 0.0, 20.0,
     Coordinate::linear, true},
    {"outflow_share", "c: how much of the gas's own temperature leaves with it", 0.0, 1.0, 0.0, 0.2,
     Coordinate::linear, true},
}};
inline constexpr Effect kHeatTransfer{"heat_transfer",
                                      Equation::energy,
                                      "heat flows between gas and wall: between adiabatic and isothermal",
                                      "p' = n (R T m'/v - p v'/v) - (p - m R T/v) h A/(c_v m), h A = G "
                                      "(p/P_a)^a (v + e)/(100 mL); out by T^(c/2)",
                                      "Electropneumatic servo (13)-(21)",
                                      kHeatTransferParameters};

template <class N>
class HeatTransfer {
 public:
  void prepare(const N* x, double gas_constant_J_kg_K, double ambient_Pa, const N& start_mass_kg) {
    per_heat_ = x[0] * (0.4 / gas_constant_J_kg_K);
    exponent_ = x[1];
    power_ = x[2];
    ends_m3_ = x[3] * 1e-6;
    half_share_ = 0.5 * x[4];
    leaving_ = N(1.0);
    per_ambient_ = 1.0 / ambient_Pa;
    mass_kg_ = start_mass_kg;
    before_1_s_ = N(0.0);
  }
  N exponent() const { return exponent_; }
  /// 1/tau of this mass.
  N relaxation_1_s(const N& mass_kg, const N& pressure_Pa, const N& volume_m3) const {
    const N wall = (volume_m3 + ends_m3_) * (1.0 / 1e-4);
    const N density = smaller(larger(pressure_Pa * per_ambient_, N(0.05)), N(20.0));
    return per_heat_ * power(density, power_) * wall / larger(mass_kg, N(1e-9));
  }
  /// 1/tau at the middle of a step that begins at this pressure, flow and squeeze moving it by `way_Pa` until then, and
  /// the heat towards `at_wall_Pa` as in the step before.
  N relaxation_at_middle_1_s(const N& mass_kg, const N& begin_Pa, const N& way_Pa, double half_step_s,
                             const N& at_wall_Pa, const N& volume_m3) {
    const N middle_Pa =
        begin_Pa + way_Pa + smaller(half_step_s * before_1_s_, N(1.0)) * (at_wall_Pa - begin_Pa);
    before_1_s_ =
        relaxation_1_s(mass_kg, smaller(larger(middle_Pa, 0.3 * begin_Pa), 3.0 * begin_Pa), volume_m3);
    leaving_ = power(smaller(larger(middle_Pa / at_wall_Pa, N(1.0 / kHottest)), N(kHottest)), half_share_);
    return before_1_s_;
  }
  /// (T/T_0)^(c/2) at the middle of that step: of the enthalpy that would leave at T_0; of the mass, its reciprocal.
  const N& leaving() const { return leaving_; }
  const N& mass_kg() const { return mass_kg_; }
  /// `at_wall_kg`: what the chamber would hold at its pressure if the gas were as warm as the wall.
  void gain(const N& mass_kg, const N& at_wall_kg) {
    mass_kg_ = smaller(larger(mass_kg_ + mass_kg, (1.0 / kHottest) * at_wall_kg), kHottest * at_wall_kg);
  }

 private:
  static constexpr double kHottest = 4.0;

  N per_heat_{}, exponent_{}, power_{}, ends_m3_{}, half_share_{}, leaving_{}, mass_kg_{}, before_1_s_{};
  double per_ambient_ = 0.0;
};

}  // namespace plenum::host::effects
