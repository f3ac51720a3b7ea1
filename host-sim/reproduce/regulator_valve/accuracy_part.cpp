// (33), (35)-(37), (39), Fig. 7 and 8, Table 4: both methods on the simulated experiment.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string>

#include "host-sim/identify/regulator_valve/discrete_model.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace id = identify::regulator_valve;

constexpr std::size_t kEvery = 4;  // sample of a chart

report::LineChart validation_chart(const Run& run, const Condition& condition) {
  const id::Branch branch = id::branch_of(run.validation, condition.direction);
  const Identified& identified = run.*condition.identified;
  report::LineChart chart{
      .title = fmt::format("{}: validation, {}", condition.figure, condition.name),
      .caption = "Free runs from the first three samples, on the same staircase with other noise.",
      .y = {"Gauge pressure", "Pa"}};
  const auto add = [&](const char* name, const std::vector<double>& deviations_Pa, report::Ink ink) {
    report::Curve curve{.name = name, .x = {}, .y = {}, .ink = ink};
    for (std::size_t k = 0; k < deviations_Pa.size(); k += kEvery) {
      curve.x.push_back(static_cast<double>(k) * branch.sample_s);
      curve.y.push_back(deviations_Pa[k] + branch.mean_pressure_Pa);
    }
    chart.curves.push_back(std::move(curve));
  };
  add("measured", branch.pressure_Pa, report::Ink::kNeutral);
  add("LS", id::free_run(identified.least_squares, branch.screw_m, branch.pressure_Pa),
      report::Ink::kPalette);
  add("PSO", id::free_run(identified.swarm.model, branch.screw_m, branch.pressure_Pa), report::Ink::kPalette);
  return chart;
}

std::string as_text(const id::DiscreteModel& model) {
  return fmt::format("b {:.0f}, a {:.4f} {:.4f} {:.4f}", model.b_Pa_m, model.a[0], model.a[1], model.a[2]);
}

}  // namespace

Part accuracy(const Campaign& campaign) {
  const Run& shown = campaign.runs.front();
  Part part{
      .title = "(33), (35)-(37), (39), Fig. 7, 8, Table 4: both methods",
      .text = fmt::format(
          "Least squares and a swarm of 40 particles and 300 iterations, on the rising and the falling "
          "branch of a noisy staircase of {:g} mm within (11), every step held for {:g} s; scored by (39) "
          "in free run on the same staircase with other noise, so on other noise alone. The paper calls "
          "Fig. 7 and 8 a validation, but tells of one step experiment, Fig. 6, and neither its holds nor "
          "whether a second one was recorded; what another staircase makes of the fit is in the next part. "
          "Three such pairs; the least fit of the three is the one that counts. Another valve and another "
          "hand than the paper's, so Table 4's percents are held to its claims: above 90 %, and PSO to be "
          "no worse than LS. Found on the first pair: LS {} up, {} down; PSO {} up, {} down.",
          1e3 * kTurn_m, kHold_s, as_text(shown.rising.least_squares), as_text(shown.falling.least_squares),
          as_text(shown.rising.swarm.model), as_text(shown.falling.swarm.model)),
      .findings = {}};
  report::BarChart bars{
      .title = "Table 4: fit (39)",
      .caption = "Ours: the least of three validations on the same staircase with other noise.",
      .categories = {},
      .value = {.quantity = "Fit", .unit = "%", .min = 85.0, .max = 100.0},
      .series = {{"paper", {}}, {"ours", {}}},
      .marks = {{report::Mark::On::kY, kClaim, "claim"}}};
  for (const Condition& condition : kConditions) {
    Fits least;
    for (const Run& run : campaign.runs) {
      least = lesser_of(
          least, fits_on(id::branch_of(run.validation, condition.direction), run.*condition.identified));
    }
    const auto add = [&](const char* method, double printed, double ours) {
      part.findings.push_back(
          {.item = fmt::format("section 6, {}", condition.figure),
           .quantity =
               fmt::format("fit of {}, {}, steps held for {:g} s, claimed above 90 % (Table 4: {:.2f} %)",
                           method, condition.name, kHold_s, printed),
           .unit = "%",
           .paper = kClaim,
           .ours = ours,
           .expect = Expect::kAtLeast,
           .why = "noise in the regressors makes the model too slow, and the steps are not held for long "
                  "enough to forgive it"});
      bars.categories.push_back(fmt::format("{}, {}", method, condition.name));
      bars.series[0].values.push_back(printed);
      bars.series[1].values.push_back(ours);
    };
    add("LS", condition.printed_least_squares, least.least_squares);
    add("PSO", condition.printed_swarm, least.swarm);
    part.findings.push_back(
        {.item = "Table 4, section 6",
         .quantity =
             fmt::format("PSO less LS, {}, steps held for {:g} s, claimed above 0 (Table 4: {:.2f})",
                         condition.name, kHold_s, condition.printed_swarm - condition.printed_least_squares),
         .unit = "points",
         .paper = 0.0,
         .ours = least.lead,
         .expect = Expect::kAtLeast,
         .why = "the swarm has stopped short of the least squares' model"});
    part.charts.emplace_back(validation_chart(shown, condition));
  }
  report::LineChart search{.title = "(35)-(37): the swarm's way",
                           .caption = "Fit of the best particle so far, three searches each.",
                           .x = {"Iteration", ""},
                           .y = {.quantity = "Fit", .unit = "%", .min = 80.0, .max = 100.0}};
  for (const Condition& condition : kConditions) {
    for (const Run& run : campaign.runs) {
      const Identified& identified = run.*condition.identified;
      double spread = 0.0;
      for (const double p : identified.branch.pressure_Pa) spread += p * p;
      report::Curve curve{.name = condition.name, .x = {}, .y = {}};
      for (std::size_t i = 0; i < identified.swarm.search.best_so_far.size(); ++i) {
        curve.x.push_back(static_cast<double>(i));
        curve.y.push_back(100.0 * (1.0 - std::sqrt(identified.swarm.search.best_so_far[i] / spread)));
      }
      search.curves.push_back(std::move(curve));
    }
  }
  part.charts.emplace_back(bars);
  part.charts.emplace_back(search);
  return part;
}

}  // namespace plenum::host::reproduce::regulator_valve
