// One function for each equation set, table or figure of the paper.
#pragma once

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::relief_valve {

Part static_characteristics();
Part cracking_and_maximum();
Part static_identification();
Part dynamic_equations();
Part multi_input_valve();
Part printed_dynamics();
Part classical_static();
Part classical_step();
Part identified_valve();
Part identified_softer_valve();

}  // namespace plenum::host::reproduce::relief_valve
