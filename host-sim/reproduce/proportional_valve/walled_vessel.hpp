// The paper's vessel behind one channel of the measured valve, its gas warmed and cooled by the wall: the
// energy balance instead of the alpha of (7), which the gas then has by itself and not as the fit takes it.
//
//   V pdot = (gamma - 1) [G_w (T_w - T) + gamma C_v (mdot_in T_0 - mdot_out T)],  T = p V / (m R)
//
// p pressure, absolute [Pa]; m gas in the vessel [kg]; V volume [m3]; mdot flows of (4), (6) [kg/s], the one
// that leaves at T, by whose root (4) divides; G_w conductance of the wall, T_w its temperature.
// At G_w = 0 a charge is (7) with alpha = gamma; with G_w without bound any flow is (7) with alpha = 1.
// Assumptions: plant/servo/chamber_law; the spool follows at once. Numerical treatment: fourth-order
// Runge-Kutta, steps of 1 ms and 0.1 kPa at most and below the time constants of flow and wall; that of the flow
// is short where the flow shuts.
#pragma once

#include "host-sim/plant/servo/chamber_law.hpp"
#include "host-sim/plant/valve.hpp"

namespace plenum::host::reproduce::proportional_valve {

/// A value, as plant::ChamberPlant. Invariant: pressure and mass stay positive.
class WalledVessel {
 public:
  /// At rest at the temperature of `gas`, between kSupply_Pa and kAmbient_Pa.
  WalledVessel(const plant::MpyeValve& valve, const plant::Gas& gas, double start_Pa,
               const plant::servo::EnergyBalance& wall);

  /// Moves on with the valve at `command_V`, as the plant reads it.
  void advance(double command_V, double duration_s);

  double pressure_Pa() const { return gas_now_.pressure_Pa; }
  double temperature_K() const;

 private:
  // of flow and wall together, at this opening
  double fastest_1_s(const plant::MpyeValve::Opening& opening) const;

  plant::MpyeValve valve_;
  plant::Gas gas_;
  plant::servo::EnergyBalance wall_;
  plant::servo::ChamberState gas_now_;
};

}  // namespace plenum::host::reproduce::proportional_valve
