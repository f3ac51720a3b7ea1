// The parts of the paper, in its order. Each is one equation set, table or figure.
#pragma once

#include <array>
#include <vector>

#include "host-sim/reproduce/finding.hpp"
#include "host-sim/reproduce/proportional_valve/identified_valve.hpp"

namespace plenum::host::reproduce::proportional_valve {

/// The vessel has some 0.03 m2 of wall, and free convection 10 to 100 W/(m2 K): its conductance lies between. Not stated.
inline constexpr std::array<double, 2> kWalls_W_K{0.3, 3.0};

/// The gas exchanges heat with the wall: its alpha is not the fit's.
struct WalledRig {
  double conductance_W_K;
  std::vector<IdentifiedSeries> series;
};

/// The four series, identified on each rig.
struct IdentifiedValve {
  std::vector<IdentifiedSeries> prompt;   ///< the spool follows at once: the paper's assumption
  std::vector<IdentifiedSeries> lagging;  ///< with the spool's lag
  std::vector<WalledRig> walled;          ///< one of each of kWalls_W_K
};

Part flow_function_part();  ///< (1)-(6), Fig. 2 and 3
Part vessel_part();         ///< (7)-(9)
Part tables_part();         ///< Tables 1 to 5 against each other and the text, Fig. 6
Part cracking_part();       ///< Tables 2 and 3 at 5 V: what a cracking ratio there may be
Part rate_fit_part(const IdentifiedValve& valve);      ///< Fig. 5, Tables 2 to 5 by the paper's method
Part pressure_fit_part(const IdentifiedValve& valve);  ///< Tables 2 to 5 by the free run
Part error_part(const IdentifiedValve& valve);         ///< Fig. 8
Part verification_part(const IdentifiedValve& valve);  ///< Fig. 9
Part leak_part();                                      ///< the same orifice on measured vessels

/// The spool of the paper's valve: 65 Hz; its damping is not stated.
RigOptions rig_with_spool();
/// The vessel's wall at the temperature of the gas that enters.
RigOptions rig_with_wall(double conductance_W_K);

}  // namespace plenum::host::reproduce::proportional_valve
