// Ports that let nothing through: a cylinder's chambers shut in.
#pragma once

#include "host-sim/plant/servo/cylinder_rates.hpp"

namespace plenum::host::reproduce::servo {

inline plant::servo::ValvePair sealed_ports() {
  plant::ThinPlateValveConfig sealed;
  sealed.inlet_area_per_V_m2 = sealed.exhaust_area_per_V_m2 = 0.0;
  sealed.inlet_leak_m2 = sealed.exhaust_leak_m2 = sealed.transition_m2 = 0.0;
  const plant::ThinPlateValve port(sealed);
  return std::array<plant::ThinPlateValve, 2>{port, port};
}

}  // namespace plenum::host::reproduce::servo
