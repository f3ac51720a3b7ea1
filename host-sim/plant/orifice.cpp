#include "host-sim/plant/orifice.hpp"

namespace plenum::host::plant {

double choked_flow_function(double gamma) {
  return std::pow(2.0 / (gamma + 1.0), 1.0 / (gamma - 1.0)) * std::sqrt(gamma / (gamma + 1.0));
}

}  // namespace plenum::host::plant
