#include "host-sim/reproduce/regulator_valve/campaign.hpp"

#include "host-sim/identify/regulator_valve/fit_measure.hpp"
#include "host-sim/identify/regulator_valve/least_squares.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace bench = plant::regulator_valve;
using identify::regulator_valve::Branch;
using identify::regulator_valve::Direction;
using identify::regulator_valve::DiscreteModel;

constexpr std::uint64_t kValidation = 1000;  // its seeds come after those of the identification

}  // namespace

bench::Recording record_staircase(double noise_Pa, std::uint64_t seed, double hold_s) {
  const bench::ValveConfig valve = bench::bench_valve();
  return bench::record(valve, {.noise_Pa = noise_Pa, .seed = seed}, valve.ambient_Pa,
                       bench::staircase(kTurn_m, kTurns, hold_s));
}

Identified identify_branch(const bench::Recording& recording, Direction direction, std::uint64_t seed) {
  const Branch branch = identify::regulator_valve::branch_of(recording, direction);
  return {.branch = branch,
          .least_squares = identify::regulator_valve::fit_least_squares(branch),
          .swarm = identify::regulator_valve::fit_swarm(branch, {.seed = seed})};
}

double free_run_fit(const DiscreteModel& model, const Branch& branch) {
  return identify::regulator_valve::fit_percent(
      branch.pressure_Pa, identify::regulator_valve::free_run(model, branch.screw_m, branch.pressure_Pa));
}

Campaign measure_campaign(int runs, const Progress& progress) {
  const double noise_Pa = bench::TestbedConfig{}.noise_Pa;
  Campaign campaign;
  for (int i = 1; i <= runs; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const bench::Recording recording = record_staircase(noise_Pa, seed);
    campaign.runs.push_back({.recording = recording,
                             .validation = record_staircase(noise_Pa, kValidation + seed),
                             .rising = identify_branch(recording, Direction::kRising, seed),
                             .falling = identify_branch(recording, Direction::kFalling, seed)});
    if (progress) progress(static_cast<double>(i) / runs);
  }
  return campaign;
}

}  // namespace plenum::host::reproduce::regulator_valve
