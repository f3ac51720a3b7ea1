// What the classical two-stage valve records where a test stand would.
#pragma once

#include <string>
#include <vector>

#include "host-sim/identify/relief_valve/static_fit.hpp"
#include "host-sim/identify/relief_valve/transient.hpp"
#include "host-sim/plant/relief_valve/grey_box.hpp"
#include "host-sim/plant/relief_valve/two_stage.hpp"

namespace plenum::host::reproduce::relief_valve {

/// Tests of the paper's Table V: flow and pressure of a change of the supply.
struct FlowChange {
  std::string name;
  double from_l_min, to_l_min;
  double rate_l_min_s;  ///< average rate of change
  double duration_s;    ///< of the record
};
/// The seven rows of Table V, in its order. The scan has 7.0 to 100.3 l/min for test 5, 77 to 94 for test 3 and
/// 99.7 to 78 for test 6; here 7.6, 77.1 and 76.0 stand, guessed from the changes printed. Good for a run, not
/// for a comparison with those changes.
const std::vector<FlowChange>& table_v();

/// The settling valve of appendix A with a main spool of less area, so that its pressure rises with the flow: A1 and A2
/// 0.2 in2 (those of its seat; printed: 1.436 in2), the preload for the same P1 - P2 at which it opens, and a drag of
/// 1000 N s/m, with which it settles. Ours, not the paper's.
plant::relief_valve::TwoStageConfig softer_valve();

/// Pressure and flow at the valve's port, every millisecond, from 20 ms before the supply begins to change.
identify::relief_valve::Transient recorded(const plant::relief_valve::TwoStagePhysics& valve,
                                           const FlowChange& change);

/// The valve at rest from `from_l_min` to `to_l_min` in equal steps of flow.
std::vector<identify::relief_valve::StaticPoint> static_points(
    const plant::relief_valve::TwoStagePhysics& valve, double from_l_min, double to_l_min, int points);

/// The source's two stages: k1 and k3 by least squares on a static curve, then the lag alone on run 1 of Table V.
plant::relief_valve::GreyBoxConfig identified_in_two_stages(
    const plant::relief_valve::TwoStagePhysics& valve,
    const std::vector<identify::relief_valve::StaticPoint>& curve);

/// Frequency [Hz] at which samples at equal steps cross `level` upward, and back; 0 for fewer than two
/// crossings.
double crossing_frequency_Hz(const std::vector<double>& samples, double step_s, double level);

}  // namespace plenum::host::reproduce::relief_valve
