// The simulated measurements that Fig. 6 to 8 and Table 4 are made from: staircases of a noisy bench, models
// identified on one, and scored on another that differs in its noise, or in its steps and holds too.
#pragma once

#include <cstddef>
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
inline constexpr double kHold_s =
    5.0;  ///< ten of the slowest time constants; of our own, the paper prints none

/// Steps of one size up to at least the top of the quarter turns, each turned in the time of a quarter turn and held.
struct Staircase {
  double step_m = kTurn_m;
  double hold_s = kHold_s;
};
/// Fig. 6: the bench valve up and down, from no pressure.
plant::regulator_valve::Recording record_staircase(double noise_Pa, std::uint64_t seed,
                                                   const Staircase& staircase = {});

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

/// Noise of the staircase that run `i` of a campaign, from 0, is validated on.
std::uint64_t validation_seed(std::size_t i);

/// One of the two conditions of the valve, and what Table 4 says of it.
struct Condition {
  const char* name;
  const char* figure;
  identify::regulator_valve::Direction direction;
  Identified Run::*identified;
  double printed_least_squares;  ///< [%]
  double printed_swarm;
};
inline constexpr Condition kConditions[] = {
    {"pressurisation", "Fig. 7", identify::regulator_valve::Direction::kRising, &Run::rising, 90.54, 92.48},
    {"exhaustion", "Fig. 8", identify::regulator_valve::Direction::kFalling, &Run::falling, 91.79, 93.11}};

/// "more than 90 % of accuracy", section 6: (39) of either method [%].
inline constexpr double kClaim = 90.0;

/// (39) of both methods [%].
struct Fits {
  double least_squares = 100.0;
  double swarm = 100.0;
  double lead = 100.0;  ///< of the swarm [points]
};
Fits fits_on(const identify::regulator_valve::Branch& branch, const Identified& identified);
/// The lesser of each; NaN where either is one, so that a fit that is none never passes for a good one.
Fits lesser_of(const Fits& a, const Fits& b);

}  // namespace plenum::host::reproduce::regulator_valve
