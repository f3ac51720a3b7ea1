// The paper's experiment V.C and V.D on the population: every chamber recorded for 100 s, once with its
// volume moving and once at rest, its model identified as the paper does, its free runs compared with the
// record.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "host-sim/reproduce/finding.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::host::reproduce::actuators {

inline constexpr std::size_t kStarts = 48;  ///< integration sequences of each record, V.D
inline constexpr double kHorizon_s = 2.0;   ///< of each sequence, V.D

struct Identified {
  PopulationChamber truth;
  trace::Log log;
  identify::Tassa9Fit one_step;  ///< of the next pressure: the paper's criterion
  identify::Tassa9Fit free_run;  ///< refined on free runs of 2 s, from there
  identify::Drift one_step_drift;
  identify::Drift free_run_drift;

  double mean_volume_mL() const { return 1e6 * truth.volume.mean_m3(); }
};

struct Study {
  std::vector<Identified> moving;
  std::vector<Identified> at_rest;  ///< the same valves and mean volumes
};

/// The first `chambers` of the population, on all processors. Takes about 0.1 s a chamber and processor.
Study study_population(std::size_t chambers, const Progress& progress);

/// The largest standard deviation of each chamber within the horizon [% of span].
std::vector<double> worst_drifts_percent(const std::vector<Identified>& chambers,
                                         identify::Drift Identified::*which);

/// The standard deviation over all sequences of all chambers together, against time [% of span].
std::vector<double> pooled_drift_percent(const std::vector<Identified>& chambers,
                                         identify::Drift Identified::*which);

/// How much the deviation of the prediction grows from the middle of the horizon to its end [% of span].
double late_growth_percent(const identify::Drift& drift);

/// Place of the chamber whose worst one-step drift is the median: what the paper calls a typical one.
std::size_t place_of_typical(const std::vector<Identified>& chambers);

}  // namespace plenum::host::reproduce::actuators
