// The parameters of a grey-box model, in image order: what they are for is in control/greybox.hpp, and of dead time,
// spool, hysteresis, sensor and supply in control/model_paths.hpp. An image may leave out what is said of the supply's line.
#pragma once

#include <cstdint>

namespace plenum::config {

enum GreyboxParameter : std::uint8_t {
  kOpenAbove,           ///< U_c [V]
  kExhaustBelow,        ///< U_r [V]
  kInletConductance,    ///< B of the inlet [mL/(s V)]
  kExhaustConductance,  ///< B of the exhaust [mL/(s V)]
  kInletLeak,           ///< L of the inlet [mL/s]
  kExhaustLeak,         ///< L of the exhaust [mL/s]
  kTransition,          ///< w [mL/s]
  kInletSlope,          ///< q of the inlet
  kInletCurve,          ///< c of the inlet
  kInletBend,           ///< e of the inlet
  kExhaustSlope,        ///< q of the exhaust
  kExhaustCurve,        ///< c of the exhaust
  kExhaustBend,         ///< e of the exhaust
  kCriticalRatio,       ///< r_b
  kSubsonicIndex,       ///< beta
  kCrackingRatio,       ///< r_a
  kDischargeSlope,      ///< k
  kDeadVolume,          ///< v_0 [mL], what the position sensor does not count
  kVolumeExponent,      ///< n, 1 (isothermal) to 1.4 (adiabatic)
  kChamberLeak,         ///< C_l [mL/s] of a narrow gap to the ambient
  kDeadTime,            ///< from a command to the valve's motion [s]
  kSpoolPeriod,         ///< 1/f of the spool on its spring [s]; 0: prompt
  kSpoolDamping,        ///< zeta of the spool
  kHysteresis,          ///< w [V], width of the valve's loop
  kSensorLag,           ///< tau of the pressure sensor [s]
  kSupply,              ///< P_c [kPa], absolute
  kAmbient,             ///< P_r [kPa], absolute
  kSupplyResistance,    ///< R [s/L] of the supply's line: its droop [kPa] for each kPa L/s
  kSupplyRecovery,      ///< tau [s] in which it recovers
  kSupplyFollowed,      ///< g: of what the board's sensor says the supply is off P_c, what the valve sees
  kGreyboxParameters
};

}  // namespace plenum::config
