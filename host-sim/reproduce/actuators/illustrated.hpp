// The valve and the pressures behind Fig. 3, 4, 6 and 7. The paper prints the pressures; of its three
// "educated guesses" of valve constants it prints none, so these are ours: one spool wider than its ports,
// one of their width, one narrower.
#pragma once

#include <array>

#include "host-sim/plant/valve.hpp"

namespace plenum::host::reproduce::actuators {

inline constexpr double kSupply_Pa = 620e3;      ///< P_c, Fig. 3
inline constexpr double kAmbient_Pa = 101325.0;  ///< P_r: 14.7 psi, V
inline constexpr double kSpan_Pa = kSupply_Pa - kAmbient_Pa;
inline constexpr double kLow_V = 3.0;  ///< commands used, V
inline constexpr double kHigh_V = 7.0;

struct IllustratedValve {
  const char* name;
  plant::ThinPlateValveConfig valve;
};

/// U_c - U_r = 0.4, 0 and -0.4 V about 5 V; B = 1.5 mm2/V, L = 0.1 mm2, transition 0.2 mm2.
inline std::array<IllustratedValve, 3> illustrated_valves() {
  const auto valve = [](double apart_V) {
    plant::ThinPlateValveConfig config;
    config.open_above_V = 5.0 + 0.5 * apart_V;
    config.exhaust_below_V = 5.0 - 0.5 * apart_V;
    config.inlet_area_per_V_m2 = config.exhaust_area_per_V_m2 = 1.5e-6;
    config.inlet_leak_m2 = config.exhaust_leak_m2 = 0.1e-6;
    config.transition_m2 = 0.2e-6;
    return config;
  };
  return {{{"spool wider than the ports", valve(0.4)}, {"as wide", valve(0.0)}, {"narrower", valve(-0.4)}}};
}

}  // namespace plenum::host::reproduce::actuators
