// V.C: "the optimization always converged to the same minimum, from different initial conditions".
#include <algorithm>
#include <thread>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/plant/random.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

constexpr std::size_t kMoving = 8;
constexpr std::size_t kAtRest = 4;
constexpr std::size_t kRandomStarts = 10;  // of each
constexpr double kSameMinimum = 1e-6;      // of the cost

/// How many of kRandomStarts starts within the bounds end at the least cost that is known of this chamber.
std::size_t at_the_least(const Identified& chamber, std::uint64_t seed) {
  const std::vector<trace::Log> logs{chamber.log};
  const trace::RigDescription rig = population_rig();
  plant::Random random(seed);
  identify::FitOptions options;
  options.explore = options.refine_free_run = false;
  std::vector<double> costs;
  double least = chamber.one_step.cost_kPa2;
  for (std::size_t i = 0; i < kRandomStarts; ++i) {
    std::array<double, identify::kFree> draw{};
    for (double& x : draw) x = random.uniform();
    options.start = identify::start_within_bounds(draw, logs, rig);
    try {
      costs.push_back(identify::fit_tassa9(logs, rig, options).cost_kPa2);
      least = std::min(least, costs.back());
    } catch (const identify::CannotIdentify&) {
      // Ended where a parameter has no influence: another minimum.
    }
  }
  return static_cast<std::size_t>(
      std::count_if(costs.begin(), costs.end(), [&](double c) { return c <= least * (1.0 + kSameMinimum); }));
}

double percent(const std::vector<std::size_t>& counts, std::size_t from, std::size_t to) {
  double sum = 0.0;
  for (std::size_t i = from; i < to; ++i) sum += static_cast<double>(counts[i]);
  return 100.0 * sum / static_cast<double>((to - from) * kRandomStarts);
}

}  // namespace

Part convergence(const Study& study, const Progress& progress) {
  const std::size_t moving = std::min(kMoving, study.moving.size());
  const std::size_t at_rest = std::min(kAtRest, study.at_rest.size());
  std::vector<std::size_t> counts(moving + at_rest);
  identify::in_parallel(
      counts.size(), std::thread::hardware_concurrency(),
      [&](std::size_t i) {
        counts[i] = at_the_least(i < moving ? study.moving[i] : study.at_rest[i - moving], i);
      },
      progress);
  Part part{
      .title = "V.C: one minimum from all starts",
      .text =
          "One-step fits from 10 random starts within the limits, the solver left to its start, on the "
          "first 8 chambers that move and the first 4 at rest. The same minimum: a cost within 1e-6 of the "
          "least that is known.",
      .findings = {}};
  part.findings = {
      {.item = "V.C",
       .quantity = "starts that end in the same minimum, volume at rest",
       .unit = "%",
       .paper = 100.0,
       .ours = percent(counts, moving, counts.size()),
       .why = "a second minimum, with the null command half a volt off"},
      {.item = "V.C",
       .quantity = "starts that end in the same minimum, volume moving",
       .unit = "%",
       .paper = 100.0,
       .ours = percent(counts, 0, moving),
       .why = "chambers that move by 20 to 40 % have a second minimum, with the null "
              "command half a volt off. The paper's starts are not told; Plenum's fit tries 12 of its own"}};
  return part;
}

}  // namespace plenum::host::reproduce::actuators
