// What a valve can do with a chamber: flow, rest and the fastest way between two pressures.
#pragma once

#include "host-sim/plant/chamber.hpp"

namespace plenum::host::plant {

/// (2) with (3): mass flow into the chamber at pressure p for a held command u [kg/s] (Fig. 4).
double mass_flow_kg_s(const Valve& valve, double pressure_Pa, double command_V, double supply_Pa,
                      double ambient_Pa);

/// The pressures at which no mass flows. One point, unless cracking ratios leave a band where neither port
/// conducts.
struct RestBand {
  double low_Pa = 0.0;
  double high_Pa = 0.0;
};
RestBand rest_band(const Valve& valve, double command_V, double supply_Pa, double ambient_Pa);

/// The root of (2) at a fixed volume (Fig. 7): where a chamber comes to rest that starts half-way from
/// ambient to supply. It is sought between half of ambient and twice the supply, to 1e-9 of the supply.
double steady_state_Pa(const Valve& valve, double command_V, double supply_Pa, double ambient_Pa);

/// The least time [s] from the present state of `start` to the first crossing of `target_Pa`: the command
/// saturated on the side of the target, no command can cross earlier on a volume at rest. Infinity when not
/// reached within 60 s.
double bang_bang_time_s(ChamberPlant start, double target_Pa, double low_V, double high_V);

}  // namespace plenum::host::plant
