// The parts of the paper, in its order. Each is one equation set or figure.
#pragma once

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::servo {

Part spool_part();                             ///< (1), Fig. 2
Part orifice_part();                           ///< (2), (3)
Part bipolynomial_part();                      ///< (4), (5)
Part chambers_part();                          ///< (6)-(21)
Part cylinder_part();                          ///< (22), Fig. 1
Part friction_part();                          ///< (23)
Part measured_friction_part();                 ///< (23) on measured pulls
Part linear_part();                            ///< (24)-(28)
Part training_part();                          ///< (29), (30), Fig. 4
Part free_run_part(const Progress& progress);  ///< (30), second of that number, Fig. 5

}  // namespace plenum::host::reproduce::servo
