#include "host-sim/reproduce/regulator_valve/campaign.hpp"

#include <cmath>

#include "host-sim/identify/regulator_valve/fit_measure.hpp"
#include "host-sim/identify/regulator_valve/least_squares.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace bench = plant::regulator_valve;
using identify::regulator_valve::Branch;
using identify::regulator_valve::Direction;
using identify::regulator_valve::DiscreteModel;

constexpr std::uint64_t kValidation = 1000;  // its seeds come after those of the identification
constexpr double kWhole = 1e-9;              // of a step: so much more than a whole number of them is one

}  // namespace

bench::Recording record_staircase(double noise_Pa, std::uint64_t seed, const Staircase& staircase) {
  const bench::ValveConfig valve = bench::bench_valve();
  const auto steps = static_cast<int>(std::ceil(kTurns * kTurn_m / staircase.step_m - kWhole));
  return bench::record(valve, {.noise_Pa = noise_Pa, .seed = seed}, valve.ambient_Pa,
                       bench::staircase(staircase.step_m, steps, staircase.hold_s));
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
  for (std::size_t i = 0; i < static_cast<std::size_t>(runs); ++i) {
    const std::uint64_t seed = i + 1;
    const bench::Recording recording = record_staircase(noise_Pa, seed);
    campaign.runs.push_back({.recording = recording,
                             .validation = record_staircase(noise_Pa, validation_seed(i)),
                             .rising = identify_branch(recording, Direction::kRising, seed),
                             .falling = identify_branch(recording, Direction::kFalling, seed)});
    if (progress) progress(static_cast<double>(seed) / runs);
  }
  return campaign;
}

std::uint64_t validation_seed(std::size_t i) {
  return kValidation + i + 1;
}

Fits fits_on(const Branch& branch, const Identified& identified) {
  const double least_squares = free_run_fit(identified.least_squares, branch);
  const double swarm = free_run_fit(identified.swarm.model, branch);
  return {least_squares, swarm, swarm - least_squares};
}

Fits lesser_of(const Fits& a, const Fits& b) {
  return {reproduce::lesser_of(a.least_squares, b.least_squares), reproduce::lesser_of(a.swarm, b.swarm),
          reproduce::lesser_of(a.lead, b.lead)};
}

}  // namespace plenum::host::reproduce::regulator_valve
