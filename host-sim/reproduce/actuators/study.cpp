#include "host-sim/reproduce/actuators/study.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

Identified identified(unsigned seed, Motion motion) {
  const trace::RigDescription rig = population_rig();
  Identified chamber{chamber_of_seed(seed, motion), record_chamber(seed, motion), {}, {}, {}, {}};
  identify::FitOptions options;
  options.refine_free_run = false;
  chamber.one_step = identify::fit_tassa9({chamber.log}, rig, options);
  options.refine_free_run = true;
  options.explore = false;
  options.start = chamber.one_step.model;
  chamber.free_run = identify::fit_tassa9({chamber.log}, rig, options);
  chamber.one_step_drift = identify::drift(chamber.log, chamber.one_step.model, kStarts, kHorizon_s);
  chamber.free_run_drift = identify::drift(chamber.log, chamber.free_run.model, kStarts, kHorizon_s);
  return chamber;
}

}  // namespace

Study study_population(std::size_t chambers, const Progress& progress) {
  Study study;
  const PopulationChamber blank{{}, plant::VolumeMotion(1e-4)};
  study.moving.resize(chambers, {blank, {}, {}, {}, {}, {}});
  study.at_rest = study.moving;
  identify::in_parallel(
      2 * chambers, std::thread::hardware_concurrency(),
      [&](std::size_t i) {
        const bool moves = i < chambers;
        const std::size_t place = i % chambers;
        (moves ? study.moving : study.at_rest)[place] =
            identified(static_cast<unsigned>(place + 1), moves ? Motion::moderate : Motion::rest);
      },
      progress);
  return study;
}

std::vector<double> worst_drifts_percent(const std::vector<Identified>& chambers,
                                         identify::Drift Identified::*which) {
  return over(chambers, [&](const Identified& chamber) { return (chamber.*which).worst_std_percent; });
}

std::vector<double> pooled_drift_percent(const std::vector<Identified>& chambers,
                                         identify::Drift Identified::*which) {
  std::vector<double> pooled;
  const auto n = static_cast<double>(kStarts);
  const auto all = n * static_cast<double>(chambers.size());
  for (std::size_t k = 0; k < (chambers.front().*which).time_s.size(); ++k) {
    double sum = 0.0;
    double square = 0.0;
    for (const Identified& chamber : chambers) {
      const double mean = (chamber.*which).mean_percent[k];
      const double deviation = (chamber.*which).std_percent[k];
      sum += n * mean;
      square += (n - 1.0) * deviation * deviation + n * mean * mean;
    }
    pooled.push_back(std::sqrt(std::max(0.0, square - sum * sum / all) / (all - 1.0)));
  }
  return pooled;
}

double late_growth_percent(const identify::Drift& drift) {
  return drift.std_percent.back() - drift.std_percent[drift.std_percent.size() / 2];
}

std::size_t place_of_typical(const std::vector<Identified>& chambers) {
  return place_of_median(worst_drifts_percent(chambers, &Identified::one_step_drift));
}

}  // namespace plenum::host::reproduce::actuators
