// What the paper does not print and Table 4 depends on: the noise, and how long a step is held.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace id = identify::regulator_valve;

constexpr double kNoises_Pa[] = {1.0, 3.0, 10.0, 50.0, 200.0, 1000.0, 3000.0};
constexpr double kHolds_s[] = {2.0, 3.0, 4.0, kHold_s, 6.0, 8.0};
constexpr std::uint64_t kSeed = 77;

struct UpAndDown {
  Identified up;
  Identified down;
};

struct Curves {
  report::Curve least_squares_up{.name = "LS, pressurisation", .x = {}, .y = {}};
  report::Curve least_squares_down{.name = "LS, exhaustion", .x = {}, .y = {}};
  report::Curve swarm_up{.name = "PSO, pressurisation", .x = {}, .y = {}};
  report::Curve swarm_down{.name = "PSO, exhaustion", .x = {}, .y = {}};

  void add(double x, const UpAndDown& identified) {
    const auto& [up, down] = identified;
    const auto put = [x](report::Curve& curve, double y) {
      curve.x.push_back(x);
      curve.y.push_back(y);
    };
    put(least_squares_up, free_run_fit(up.least_squares, up.branch));
    put(least_squares_down, free_run_fit(down.least_squares, down.branch));
    put(swarm_up, free_run_fit(up.swarm.model, up.branch));
    put(swarm_down, free_run_fit(down.swarm.model, down.branch));
  }
  int swarm_below() const {  // a fit that is none counts
    int count = 0;
    for (std::size_t i = 0; i < swarm_up.y.size(); ++i)
      count += !(swarm_up.y[i] >= least_squares_up.y[i]) + !(swarm_down.y[i] >= least_squares_down.y[i]);
    return count;
  }
  // Before which of the points, from the first, some fit is below the claim; their number where the last one is.
  std::size_t claimed_from() const {
    std::size_t from = swarm_up.y.size();
    const auto kept = [&](std::size_t i) {
      return least_squares_up.y[i] >= kClaim && least_squares_down.y[i] >= kClaim &&
             swarm_up.y[i] >= kClaim && swarm_down.y[i] >= kClaim;
    };
    while (from > 0 && kept(from - 1)) --from;
    return from;
  }
  std::vector<report::Curve> all() const {
    return {least_squares_up, least_squares_down, swarm_up, swarm_down};
  }
};

// Of the noises tried, the one at which least squares comes nearest to a model of (34) in a.
struct Nearest {
  const id::DiscreteModel& printed;
  double noise_Pa = 0.0;
  double off = std::numeric_limits<double>::infinity();
  id::DiscreteModel found{};

  void consider(const id::DiscreteModel& model, double at_Pa) {
    double distance = 0.0;
    for (std::size_t i = 0; i < 3; ++i) distance = greater_of(distance, std::abs(model.a[i] - printed.a[i]));
    if (!(distance < off)) return;
    off = distance;
    noise_Pa = at_Pa;
    found = model;
  }
  void add_to(std::vector<Finding>& findings, const char* condition, const char* b) const {
    const std::string why = fmt::format(
        "the bench is another valve under another noise: at {:g} Pa its a are {:.4f}, {:.4f}, {:.4f}, "
        "nearest to (34); with less noise they go towards those of the bench valve, with more towards -1/3 "
        "each",
        noise_Pa, found.a[0], found.a[1], found.a[2]);
    findings.push_back(
        {.item = "(34)",
         .quantity = fmt::format("largest distance of ours from the printed a, LS, {}, at {:g} Pa, of {} "
                                 "noises the one with the least",
                                 condition, noise_Pa, std::size(kNoises_Pa)),
         .paper = 0.0,
         .ours = off,
         .tolerance = 0.5e-4,  // half the last digit printed
         .why = why});
    findings.push_back({.item = "(34)",
                        .quantity = fmt::format("{}, LS, {}, at that noise", b, condition),
                        .unit = "Pa/m",
                        .paper = printed.b_Pa_m,
                        .ours = found.b_Pa_m,
                        .tolerance = 0.05,
                        .why = why});
  }
};

// What the holds do to the claim, from the fits themselves.
std::string holds_text(const Curves& by_hold) {
  std::string text = "on exhaustion least squares has";
  const std::vector<double>& fits = by_hold.least_squares_down.y;
  for (std::size_t i = 0; i < fits.size(); ++i)
    text += fmt::format("{} {:.2f} % with holds of {:g} s", i == 0 ? "" : ",", fits[i], kHolds_s[i]);
  const std::size_t from = by_hold.claimed_from();
  return text + (from == fits.size()
                     ? "; at none of them are both methods above 90 % on both conditions"
                     : fmt::format("; both methods are above 90 % on both conditions from {:g} s on",
                                   kHolds_s[from]));
}

}  // namespace

Part influence_of_noise(const Progress& progress) {
  const double bench_noise_Pa = plant::regulator_valve::TestbedConfig{}.noise_Pa;
  const double all = static_cast<double>(std::size(kNoises_Pa) + std::size(kHolds_s) - 1);  // they share one
  double done = 0.0;
  const auto both = [&](double noise_Pa, double hold_s) {
    const auto recording = record_staircase(noise_Pa, kSeed, {.hold_s = hold_s});
    UpAndDown identified{identify_branch(recording, id::Direction::kRising, kSeed),
                         identify_branch(recording, id::Direction::kFalling, kSeed)};
    if (progress) progress(++done / all);
    return identified;
  };

  Curves by_noise;
  UpAndDown as_on_the_bench;
  report::Curve a[3] = {{.name = "a_1", .x = {}, .y = {}},
                        {.name = "a_2", .x = {}, .y = {}},
                        {.name = "a_3", .x = {}, .y = {}}};
  Nearest rising{.printed = kPrintedLeastSquares.rising};
  Nearest falling{.printed = kPrintedLeastSquares.falling};
  for (const double noise_Pa : kNoises_Pa) {
    const UpAndDown identified = both(noise_Pa, kHold_s);
    by_noise.add(noise_Pa, identified);
    if (noise_Pa == bench_noise_Pa) as_on_the_bench = identified;
    const auto& found = identified.up.least_squares.a;
    for (std::size_t i = 0; i < 3; ++i) {
      a[i].x.push_back(noise_Pa);
      a[i].y.push_back(found[i]);
    }
    rising.consider(identified.up.least_squares, noise_Pa);
    falling.consider(identified.down.least_squares, noise_Pa);
  }
  Curves by_hold;
  for (const double hold_s : kHolds_s) {
    by_hold.add(hold_s, hold_s == kHold_s ? as_on_the_bench : both(bench_noise_Pa, hold_s));
  }

  report::XyChart coefficients{.title = "(34): least squares over the noise",
                               .caption =
                                   "Rising branch. Marks: the printed a_1, a_2, a_3. Without noise they "
                                   "would be near -2.9, 2.8, -0.9; with much, -1/3 each.",
                               .x = {.quantity = "Noise", .unit = "Pa", .logarithmic = true},
                               .y = {"Coefficient", ""},
                               .curves = {a[0], a[1], a[2]},
                               .marks = {}};
  const char* const names[] = {"a_1 of (34)", "a_2 of (34)", "a_3 of (34)"};
  for (std::size_t i = 0; i < 3; ++i)
    coefficients.marks.push_back({report::Mark::On::kY, kPrintedLeastSquares.rising.a[i], names[i]});
  std::vector<Finding> findings{
      {.item = "Table 4, section 6",
       .quantity = fmt::format("cases with PSO below LS, of {:g}: both conditions, {} noises, {} more holds",
                               2.0 * all, std::size(kNoises_Pa), std::size(kHolds_s) - 1),
       .paper = 0.0,
       .ours = static_cast<double>(by_noise.swarm_below() + by_hold.swarm_below()),
       .why = "the swarm has stopped short of the least squares' model"}};
  rising.add_to(findings, "pressurisation", "b_0");
  falling.add_to(findings, "exhaustion", "b_1");
  return {
      .title = "(33), (34): what the noise does to least squares",
      .text = fmt::format(
          "The same staircase with more and less noise, and with shorter and longer holds; fits on the data "
          "themselves. Least squares predicts the next sample from three noisy ones: with noise its "
          "coefficients go to the average of the three and its poles are no longer the valve's. The rising "
          "model of (34) has a_1, a_2, a_3 = -1.3735, -0.1457, 0.5200; our least squares comes nearest with "
          "{:.4f}, {:.4f}, {:.4f} at {:g} Pa. That is why masses and springs made from (34) mean little "
          "(below), and why PSO, which fits the free run, is better. Table 4's claim depends on what the "
          "paper does not print: {}.",
          rising.found.a[0], rising.found.a[1], rising.found.a[2], rising.noise_Pa, holds_text(by_hold)),
      .findings = std::move(findings),
      .charts = {coefficients,
                 report::XyChart{.title = "Fit (39) over the noise",
                                 .caption = "Steps held for 5 s.",
                                 .x = {.quantity = "Noise", .unit = "Pa", .logarithmic = true},
                                 .y = {"Fit", "%"},
                                 .curves = by_noise.all(),
                                 .marks = {{report::Mark::On::kY, kClaim, "claim"}}},
                 report::XyChart{.title = "Fit (39) over the hold",
                                 .caption = "1 kPa of noise. The shorter the hold, the more the transients "
                                            "weigh, where least squares is wrong.",
                                 .x = {"Hold of each step", "s"},
                                 .y = {"Fit", "%"},
                                 .curves = by_hold.all(),
                                 .marks = {{report::Mark::On::kY, kClaim, "claim"}}}}};
}

}  // namespace plenum::host::reproduce::regulator_valve
