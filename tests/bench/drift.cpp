// How far free runs drift from the measurement (Fig. 13), over the fixed population of 76 valve-chambers.
//
// Each chamber is recorded for 100 s, its model fitted to that record, and the record predicted in 48 free
// runs of 2 s. The drift of a chamber is the largest standard deviation over its starts within the 2 s, in
// percent of P_c - P_r; the rows are the 95th percentile (nearest rank: the 73rd of 76) and the largest of
// the 76. Beside the population the same valves on volumes at rest, and the fit stopped after the one step.
//
// The targets are missed where the volume moves, and no fit of the published form was found that comes near:
// free-run stretches of 0.3 to 100 s gave a 95th percentile of 17.9 to 15.4 and a maximum of 29.8 to 16.7,
// c_gamma of 0.02 to 2 V 15.9 to 16.5 and 16.8 to 18.8, the best in free run of 20 more starts a chamber
// (null moved by up to 0.6 V, four c_gamma) 15.3 and 16.8. The form has v-dot in the wrong place.
//
// usage: plenum_drift_bench [FILE]    FILE: one line a chamber, for looking into the worst
#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host;
using reproduce::actuators::Motion;

constexpr std::size_t kChambers = 76;
constexpr std::size_t kStarts = 48;
constexpr double kHorizon_s = 2.0;
constexpr unsigned kFirstSeed = 1;

struct ChamberDrift {
  double one_step_percent = 0.0;  ///< fitted to the next tick only, as the paper
  double free_run_percent = 0.0;  ///< and refined on free runs, as the tools
};

ChamberDrift drift_of(unsigned seed, Motion motion) {
  const trace::Log log = reproduce::actuators::record_chamber(seed, motion);
  const trace::RigDescription rig = reproduce::actuators::population_rig();
  const auto worst = [&](const identify::Tassa9& model) {
    return identify::drift(log, model, kStarts, kHorizon_s).worst_std_percent;
  };
  identify::FitOptions options;
  options.refine_free_run = false;
  const identify::Tassa9Fit one_step = identify::fit_tassa9({log}, rig, options);
  options.refine_free_run = true;
  const identify::Tassa9Fit free_run = identify::fit_tassa9({log}, rig, options);
  return {worst(one_step.model), worst(free_run.model)};
}

void print_rows(const std::string& prefix, const std::vector<double>& drifts,
                std::optional<double> p95_target = {}, std::optional<double> max_target = {}) {
  using plenum::bench::p95;
  plenum::bench::print(
      {"drift." + prefix + "p95_percent_span", p95(drifts), "% of span", "lower", p95_target});
  const double max = *std::max_element(drifts.begin(), drifts.end());
  plenum::bench::print({"drift." + prefix + "max_percent_span", max, "% of span", "lower", max_target});
}

}  // namespace

int main(int count, char** words) {
  std::array<std::vector<ChamberDrift>, 2> drifts{std::vector<ChamberDrift>(kChambers),
                                                  std::vector<ChamberDrift>(kChambers)};
  identify::in_parallel(2 * kChambers, std::thread::hardware_concurrency(), [&](std::size_t i) {
    const bool moves = i < kChambers;
    const std::size_t chamber = i % kChambers;
    drifts[moves ? 1 : 0][chamber] =
        drift_of(kFirstSeed + static_cast<unsigned>(chamber), moves ? Motion::moderate : Motion::rest);
  });
  if (count > 1) {
    if (std::FILE* const file = std::fopen(words[1], "w")) {
      for (std::size_t i = 0; i < kChambers; ++i) {
        std::fprintf(file, "%zu %.3f %.3f %.3f %.3f\n", i + kFirstSeed, drifts[1][i].free_run_percent,
                     drifts[1][i].one_step_percent, drifts[0][i].free_run_percent,
                     drifts[0][i].one_step_percent);
      }
      std::fclose(file);
    }
  }
  const auto of = [&](bool moves, double ChamberDrift::*which) {
    std::vector<double> values;
    for (const ChamberDrift& drift : drifts[moves ? 1 : 0]) values.push_back(drift.*which);
    return values;
  };
  print_rows("", of(true, &ChamberDrift::free_run_percent), 4.0, 10.0);
  print_rows("one_step_fit_", of(true, &ChamberDrift::one_step_percent));
  print_rows("fixed_volume_", of(false, &ChamberDrift::free_run_percent));
  print_rows("fixed_volume_one_step_fit_", of(false, &ChamberDrift::one_step_percent));
}
