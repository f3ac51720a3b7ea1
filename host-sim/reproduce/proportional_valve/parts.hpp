// The parts of the paper, in its order. Each is one equation set, table or figure.
#pragma once

#include <vector>

#include "host-sim/reproduce/finding.hpp"
#include "host-sim/reproduce/proportional_valve/identified_valve.hpp"

namespace plenum::host::reproduce::proportional_valve {

/// The four series, identified on a rig without and with the spool's lag.
struct IdentifiedValve {
  std::vector<IdentifiedSeries> prompt;  ///< the spool follows at once: the paper's assumption
  std::vector<IdentifiedSeries> lagging;
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

}  // namespace plenum::host::reproduce::proportional_valve
