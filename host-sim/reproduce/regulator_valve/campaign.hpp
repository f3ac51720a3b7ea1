// The simulated measurements that Fig. 6 to 8 and Table 4 are made from: staircases of a noisy bench, models
// identified on one, and scored on another that differs in its noise.
#pragma once

#include <cstdint>
#include <vector>

#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/discrete_model.hpp"
#include "host-sim/identify/regulator_valve/swarm_fit.hpp"
#include "host-sim/plant/regulator_valve/testbed.hpp"
#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::regulator_valve {

inline constexpr double kTurn_m = 0.25e-3;  ///< a quarter turn of the knob, the step of Fig. 5
inline constexpr int kTurns = 13;           ///< up to 3.25 mm: beyond the range of (11)
inline constexpr double kHold_s = 5.0;      ///< ten of the slowest time constants

/// Fig. 6: the bench valve up and down in quarter turns, from no pressure.
plant::regulator_valve::Recording record_staircase(double noise_Pa, std::uint64_t seed,
                                                   double hold_s = kHold_s);

/// Both methods on one branch.
struct Identified {
  identify::regulator_valve::Branch branch;  ///< what they were identified on
  identify::regulator_valve::DiscreteModel least_squares;
  identify::regulator_valve::SwarmFit swarm;
};
Identified identify_branch(const plant::regulator_valve::Recording& recording,
                           identify::regulator_valve::Direction direction, std::uint64_t seed);

/// (39) of the free run of `model` over `branch` [%].
double free_run_fit(const identify::regulator_valve::DiscreteModel& model,
                    const identify::regulator_valve::Branch& branch);

/// One measurement, and the one it is validated on.
struct Run {
  plant::regulator_valve::Recording recording;
  plant::regulator_valve::Recording validation;
  Identified rising;
  Identified falling;
};

struct Campaign {
  std::vector<Run> runs;
};
Campaign measure_campaign(int runs, const Progress& progress);

}  // namespace plenum::host::reproduce::regulator_valve
