// Areas that rise with the opening over all of the command range, as a spool's do: where no command was, a curve that fits may
// fall.
//
//   e_i = W max(0, s - (b(o_i) - b(o_(i-1)))/d),   b(o) = o m(o),   o_i = i d up to 10 V, both ports
//
// m of effects/area_shape.hpp; s least slope [1]; W so large that no fit pays for a slope below 0. Vanishes where b rises.
#pragma once

#include <Eigen/Core>

#include "host-sim/effects/catalogue.hpp"

namespace plenum::host::identify::chamber {

/// The errors e_i [Pa], those of the inlet first.
Eigen::VectorXd falling_areas_Pa(const effects::Figures& figures);

}  // namespace plenum::host::identify::chamber
