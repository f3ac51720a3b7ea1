// A machine of the middle of the population, for departures that are drawn without one.
#pragma once

#include "host-sim/blind/departures.hpp"

namespace plenum::host::blind {

inline constexpr Scale kMiddlingScale{.size = 1.0,
                                      .supply_Pa = 600e3,
                                      .ambient_Pa = 101325.0,
                                      .temperature_K = 293.15,
                                      .volume_m3 = 150e-6,
                                      .moves = true,
                                      .area_per_V_m2 = 1.5e-6,
                                      .discharge_coefficient = 0.72,
                                      .flow_kg_s_m2 = 1000.0};

}  // namespace plenum::host::blind
