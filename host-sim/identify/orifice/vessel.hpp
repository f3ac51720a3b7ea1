// A vessel of fixed volume that fills or empties through one orifice, and the record of its pressure.
//
//   Charge:     p_u = far pressure (the supply), p_d = vessel,                 pdot = +k p_u psi_e / psi_max
//   Discharge:  p_u = vessel, p_d = far pressure (the surroundings),           pdot = -k p_u psi_e / psi_max
//   k = A C_d psi_max alpha sqrt(2 R T_0) / V                                                       (7), (4)
//
// p pressures, absolute [Pa]; k choked rate [1/s]; A area of the orifice [m2]; C_d discharge coefficient [-];
// V volume [m3]; alpha exponent of the flow term, 1 isothermal to gamma adiabatic [-]; psi_e: plant/orifice.
// A pressure record knows k. The area follows from it only as far as C_d, alpha and V are known.
//
// Source: "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve Model"
// (4), (7). Its (8) prints sqrt(2 R T_0 / V), which does not follow from them.
#pragma once

#include <optional>
#include <vector>

#include "host-sim/plant/gas.hpp"

namespace plenum::host::identify::orifice {

enum class Flow {
  kCharge,     ///< from the far side into the vessel
  kDischarge,  ///< out of the vessel to the far side
};

/// What turns the choked rate into an area.
struct Vessel {
  std::optional<double> volume_m3{};   ///< none: the area stays unknown
  double flow_exponent = 1.4;          ///< alpha; slow leaks are isothermal: 1
  double discharge_coefficient = 1.0;  ///< C_d; at 1 the area found is the effective one, C_d A
  plant::Gas gas = plant::reference_atmosphere();
};

/// k / A [1/(s m2)]; none where the volume is unknown. Throws std::invalid_argument naming a figure out of
/// range.
std::optional<double> choked_rate_of_area_1_s_m2(const Vessel& vessel);

/// One charge or discharge at a constant opening. Columns of equal length; time rises, evenly or not.
struct VesselRecord {
  Flow flow = Flow::kCharge;
  std::vector<double> time_s;
  std::vector<double> vessel_Pa;  ///< absolute
  std::vector<double> far_Pa;     ///< absolute; supply for a charge, surroundings for a discharge
};

/// Throws std::invalid_argument naming column and row (from 1): columns of unequal length, fewer than
/// `least_rows`, a pressure that is not above 0, a time that does not rise.
void validate(const VesselRecord& record, std::size_t least_rows = 2);

/// Downstream over upstream pressure in row `i`.
double pressure_ratio(const VesselRecord& record, std::size_t i);

}  // namespace plenum::host::identify::orifice
