// Do random starts end in the same minimum, and how long does a fleet take?
//
// 100 starts drawn within the bounds, on 8 chambers that move and 4 at rest. The same: a cost within 1e-6 of
// the least that any start reached on that chamber. Once as the tools fit (exploring), once with the solver
// left to the start it is given.
#include <array>
#include <chrono>
#include <cstdio>
#include <limits>
#include <random>
#include <thread>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "tests/bench/row.hpp"

namespace {

using plenum::host::reproduce::actuators::Motion;
using plenum::host::reproduce::actuators::population_rig;
using plenum::host::reproduce::actuators::record_chamber;
using namespace plenum::host;

constexpr std::size_t kStarts = 100;
constexpr std::size_t kMoving = 8;
constexpr std::size_t kAtRest = 4;
constexpr std::size_t kFleet = 76;
const unsigned kThreads = std::thread::hardware_concurrency();

struct Outcome {
  std::size_t same[2] = {0, 0};  ///< left to the start, exploring
};

Outcome starts_on(unsigned seed, bool moves) {
  const std::vector<trace::Log> logs{record_chamber(seed, moves ? Motion::moderate : Motion::rest)};
  const auto rig = population_rig();
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit;
  std::vector<std::array<double, 2>> costs(kStarts);
  double least = std::numeric_limits<double>::infinity();
  for (auto& cost : costs) {
    std::array<double, identify::kFree> draw{};
    for (double& x : draw) x = unit(random);
    identify::FitOptions options;
    options.refine_free_run = false;
    options.start = identify::start_within_bounds(draw, logs, rig);
    for (const bool explore : {false, true}) {
      options.explore = explore;
      double& reached = cost[explore ? 1 : 0];
      try {
        reached = identify::fit_tassa9(logs, rig, options).cost_kPa2;
      } catch (const identify::CannotIdentify&) {
        reached = std::numeric_limits<double>::infinity();
      }
      least = std::min(least, reached);
    }
  }
  Outcome outcome;
  for (const auto& cost : costs) {
    for (std::size_t how = 0; how < 2; ++how) {
      if (cost[how] <= least * (1.0 + 1e-6)) ++outcome.same[how];
    }
  }
  std::fprintf(stderr, "chamber %u, volume %s: %zu of %zu starts alone, %zu exploring\n", seed,
               moves ? "moving" : "at rest", outcome.same[0], kStarts, outcome.same[1]);
  return outcome;
}

}  // namespace

int main() {
  std::vector<Outcome> outcomes(kMoving + kAtRest);
  identify::in_parallel(outcomes.size(), kThreads, [&](std::size_t i) {
    outcomes[i] = starts_on(static_cast<unsigned>(i + 1), i < kMoving);
  });
  double exploring = 0.0, alone_moving = 0.0, alone_at_rest = 0.0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    exploring += static_cast<double>(outcomes[i].same[1]) / static_cast<double>(outcomes.size());
    (i < kMoving ? alone_moving : alone_at_rest) +=
        static_cast<double>(outcomes[i].same[0]) / static_cast<double>(i < kMoving ? kMoving : kAtRest);
  }
  plenum::bench::print({"identify.same_minimum_percent", exploring, "%", "higher", 99.0});
  plenum::bench::print({"identify.same_minimum_percent_unaided_at_rest", alone_at_rest, "%", "higher", 99.0});
  plenum::bench::print({"identify.same_minimum_percent_unaided_moving", alone_moving, "%", "higher", 99.0});

  std::vector<trace::Log> fleet(kFleet);
  identify::in_parallel(kFleet, kThreads, [&](std::size_t i) {
    fleet[i] = record_chamber(static_cast<unsigned>(1000 + i), Motion::moderate);
  });
  const auto begin = std::chrono::steady_clock::now();
  identify::in_parallel(kFleet, kThreads,
                        [&](std::size_t i) { identify::fit_tassa9({fleet[i]}, population_rig()); });
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  plenum::bench::print({"identify.fleet_s", took.count(), "s"});
}
