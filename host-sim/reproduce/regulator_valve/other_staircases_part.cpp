// Table 4 on staircases that the models were not identified on: other steps, other holds.
#include <fmt/format.h>

#include <cstddef>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/reproduce/regulator_valve/parts.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace id = identify::regulator_valve;

// Half and twice the steps, half and twice the holds, of what the models are identified on.
constexpr Staircase kOthers[] = {{.step_m = 0.5 * kTurn_m},
                                 {.step_m = 2.0 * kTurn_m},
                                 {.hold_s = 0.5 * kHold_s},
                                 {.hold_s = 2.0 * kHold_s}};

std::string name_of(const Staircase& staircase) {
  return fmt::format("{:g} mm, {:g} s", 1e3 * staircase.step_m, staircase.hold_s);
}

using Recordings = std::vector<plant::regulator_valve::Recording>;

// One for each run of the campaign, with the noise that its validation has.
Recordings record_each(const Staircase& staircase, double noise_Pa, const Campaign& campaign) {
  Recordings recordings;
  for (std::size_t i = 0; i < campaign.runs.size(); ++i)
    recordings.push_back(record_staircase(noise_Pa, validation_seed(i), staircase));
  return recordings;
}

// The least over the runs, of a condition's models on their recordings.
Fits least_on(const Recordings& recordings, const Condition& condition, const Campaign& campaign) {
  Fits least;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    least = lesser_of(least, fits_on(id::branch_of(recordings[i], condition.direction),
                                     campaign.runs[i].*condition.identified));
  }
  return least;
}

// Of models identified on that very staircase, on the data themselves.
Fits own_fits(const Staircase& staircase, double noise_Pa, const Condition& condition) {
  const Identified own = identify_branch(record_staircase(noise_Pa, 1, staircase), condition.direction, 1);
  return fits_on(own.branch, own);
}

// Why one method is below the claim, by what it has where it was identified on the very staircase.
std::string why_below(const char* method, double own) {
  if (own >= kClaim) {
    return fmt::format("the model does not carry over: identified on this very staircase {} has {:.1f} %",
                       method, own);
  }
  return fmt::format(
      "it is the staircase more than the model, since identified on this very one {} has {:.1f} %: what a "
      "model does wrong it does while the pressure moves, and (39) spreads that over the range and over the "
      "rests between the steps, so large steps and short holds score low",
      method, own);
}

// Why the swarm is behind least squares, by what it has where the free run starts from three samples without noise.
std::string why_behind(double quiet_lead) {
  return fmt::format(
      "PSO is the best free run only on the staircase that it was identified on, and a free run carries the "
      "noise of the three samples it starts from: without noise the least of PSO less LS is {:+.2f}",
      quiet_lead);
}

report::BarChart empty_bars(const Condition& condition) {
  return {.title = fmt::format("Fit (39) on other staircases, {}", condition.name),
          .caption = "The least of three. First: the staircase of the identification.",
          .categories = {},
          .value = {.quantity = "Fit", .unit = "%", .min = 70.0, .max = 100.0},
          .series = {{"LS", {}}, {"PSO", {}}},
          .marks = {{report::Mark::On::kY, kClaim, "claim"}}};
}

void draw(report::BarChart& bars, const Staircase& staircase, const Fits& least) {
  bars.categories.push_back(name_of(staircase));
  bars.series[0].values.push_back(least.least_squares);
  bars.series[1].values.push_back(least.swarm);
}

std::vector<Finding> findings_of(const Staircase& staircase, double noise_Pa, const Condition& condition,
                                 const Campaign& campaign, const Fits& least) {
  const bool kept = least.least_squares >= kClaim && least.swarm >= kClaim;
  const Fits own = kept ? Fits{} : own_fits(staircase, noise_Pa, condition);
  const double quiet_lead =
      least.lead >= 0.0 ? 0.0 : least_on(record_each(staircase, 0.0, campaign), condition, campaign).lead;
  const auto finding = [&](const char* what, const char* unit, double bound, double ours, std::string why) {
    return Finding{
        .item = fmt::format("Table 4, {}", condition.figure),
        .quantity = fmt::format("{}, {}, on steps of {}", what, condition.name, name_of(staircase)),
        .unit = unit,
        .paper = bound,
        .ours = ours,
        .expect = Expect::kAtLeast,
        .instead = "the claim",
        .why = std::move(why)};
  };
  return {finding("fit of LS", "%", kClaim, least.least_squares, why_below("LS", own.least_squares)),
          finding("fit of PSO", "%", kClaim, least.swarm, why_below("PSO", own.swarm)),
          finding("PSO less LS", "points", 0.0, least.lead, why_behind(quiet_lead))};
}

}  // namespace

Part other_staircases(const Campaign& campaign) {
  const double noise_Pa = plant::regulator_valve::TestbedConfig{}.noise_Pa;
  Part part{
      .title = "Table 4 on another staircase",
      .text = fmt::format(
          "The models of the part before, identified on steps of {:g} mm held for {:g} s, scored by (39) in "
          "free run on staircases that have half or twice those steps, or half or twice those holds, with "
          "other noise; every step is turned in the same time. The least of three counts. The claim, above "
          "90 % and PSO not below LS, names no staircase.",
          1e3 * kTurn_m, kHold_s),
      .findings = {}};
  std::vector<report::BarChart> bars;
  Recordings first;
  for (const Run& run : campaign.runs) first.push_back(run.validation);
  for (const Condition& condition : kConditions) {
    bars.push_back(empty_bars(condition));
    draw(bars.back(), {}, least_on(first, condition, campaign));
  }
  for (const Staircase& staircase : kOthers) {
    const Recordings recordings = record_each(staircase, noise_Pa, campaign);
    for (std::size_t i = 0; i < std::size(kConditions); ++i) {
      const Fits least = least_on(recordings, kConditions[i], campaign);
      draw(bars[i], staircase, least);
      for (Finding& finding : findings_of(staircase, noise_Pa, kConditions[i], campaign, least))
        part.findings.push_back(std::move(finding));
    }
  }
  for (report::BarChart& chart : bars) part.charts.emplace_back(std::move(chart));
  return part;
}

}  // namespace plenum::host::reproduce::regulator_valve
