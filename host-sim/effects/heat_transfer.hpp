// heat_transfer: the walls take heat from the gas, so that it is not compressed adiabatically.
//
//   p' = n (R T_0 (m_c - m_r)/v - p v'/v) - (p - m R T_0/v)/tau,    tau = c_v m/(h A),   m' = m_c - m_r
//
// p [Pa], v [m3], m mass of the gas [kg], T_0 wall [K], h A conductance to the wall [W/K], c_v = R/(kappa - 1); n
// exponent [-]. p v/(m R) is the gas temperature that the balance implies. Assumptions: gas leaves at T_0, as in
// (4). Vanishes at h A = 0 with n = kappa, exactly (4); h A -> infinity is the isothermal chamber. Numerical
// treatment: the relaxation enters rate and slope of the step, with the mass expected at its middle; m then moves by
// the mass that the step's own balance of energy has moved. Source: "Electropneumatic servo" (13)-(21).
#pragma once

#include <array>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kHeatTransferParameters{{
    {"conductance_W_K", "h A to the wall", 0.0, 50.0, 0.0, 0.05},
    {"exponent", "n: 1.4 adiabatic, 1 isothermal", 1.0, 1.4, 1.4, 0.05},
}};
inline constexpr Effect kHeatTransfer{"heat_transfer",
                                      Equation::energy,
                                      "heat flows between gas and wall: between adiabatic and isothermal",
                                      "p' = n (R T m'/v - p v'/v) - (p - m R T/v) h A/(c_v m)",
                                      "Electropneumatic servo (13)-(21)",
                                      kHeatTransferParameters};

template <class N>
class HeatTransfer {
 public:
  /// `start_mass_kg`: the gas begins at wall temperature.
  void prepare(const N* x, double gas_constant_J_kg_K, const N& start_mass_kg) {
    per_heat_ = x[0] * (0.4 / gas_constant_J_kg_K);
    exponent_ = x[1];
    mass_kg_ = start_mass_kg;
  }
  N exponent() const { return exponent_; }
  /// 1/tau of this mass.
  N relaxation_1_s(const N& mass_kg) const { return per_heat_ / larger(mass_kg, N(1e-9)); }
  const N& mass_kg() const { return mass_kg_; }
  void gain(const N& mass_kg) { mass_kg_ += mass_kg; }

 private:
  N per_heat_{}, exponent_{}, mass_kg_{};
};

}  // namespace plenum::host::effects
