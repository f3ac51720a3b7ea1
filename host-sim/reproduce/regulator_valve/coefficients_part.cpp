// (34) and (38): the printed coefficients beside those of our staircases.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <string>

#include "host-sim/identify/regulator_valve/least_squares.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace id = identify::regulator_valve;

std::string as_text(const id::DiscreteModel& model) {
  return fmt::format("b {:.0f}, a {:.3f}, {:.3f}, {:.3f}", model.b_Pa_m, model.a[0], model.a[1], model.a[2]);
}

// What the least squares' coefficients would be without noise.
std::string why_of_least_squares(const Condition& condition) {
  const id::DiscreteModel quiet =
      id::fit_least_squares(id::branch_of(record_staircase(0.0, 1), condition.direction));
  return fmt::format(
      "noise in the three past pressures pulls the three a of (33) to their average, -1/3 each, and b with "
      "them, since the static gain stays; without noise LS has {} on this bench, so they tell more of the "
      "noise, which the paper does not print, than of the valve, which is another",
      as_text(quiet));
}

// How far the swarm's own models lie apart, ours over the runs, and the paper's from its least squares.
std::string why_of_swarm(const Condition& condition, const Campaign& campaign,
                         const id::DiscreteModel& printed, const id::DiscreteModel& printed_least_squares) {
  const auto first_a = [&](const Run& run) { return (run.*condition.identified).swarm.model.a[0]; };
  const auto [least, most] =
      std::minmax_element(campaign.runs.begin(), campaign.runs.end(),
                          [&](const Run& left, const Run& right) { return first_a(left) < first_a(right); });
  double moved = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    moved = std::max(moved, std::abs(printed.a[i] - printed_least_squares.a[i]));
  return fmt::format(
      "the free run tells the static gain and the slowest pole, and under noise hardly the other two: over "
      "{} staircases of one valve our {} lies anywhere from {:.2f} to {:.2f}; the paper's is another valve, "
      "and its swarm stays within {:.4f} of the a of (34)",
      campaign.runs.size(), condition.direction == id::Direction::kRising ? "a_1" : "a_4", first_a(*least),
      first_a(*most), moved);
}

// The poles of printed and of our models in the plane of z.
report::XyChart poles_chart(const Condition& condition) {
  return {
      .title = fmt::format("(34), (38): poles, {}", condition.name),
      .caption =
          "All have one pole near 1, the slow one. Where the other two lie, the noise decides for LS, and "
          "hardly anything for PSO.",
      .x = {.quantity = "Re z", .min = -1.0, .max = 1.0},
      .y = {.quantity = "Im z", .min = -1.0, .max = 1.0}};
}

report::Curve poles_of(const id::DiscreteModel& model, std::string name) {
  report::Curve curve{.name = std::move(name), .x = {}, .y = {}, .stroke = report::Stroke::kPoints};
  for (const std::complex<double>& z : id::poles(model)) {
    curve.x.push_back(z.real());
    curve.y.push_back(z.imag());
  }
  return curve;
}

}  // namespace

Part printed_coefficients(const Campaign& campaign) {
  constexpr double kLastOfA = 0.5e-4;  // half the last digit printed
  constexpr double kLastOfB_Pa_m = 0.05;
  Part part{
      .title = "(34), (38): the coefficients beside ours",
      .text = fmt::format(
          "The sixteen coefficients that the paper prints, beside those of the first of our staircases, "
          "with {:g} Pa of noise; the tolerance is half of the last digit. Another valve under another "
          "noise need not have them; how they go with the noise is in the part on noise.",
          plant::regulator_valve::TestbedConfig{}.noise_Pa),
      .findings = {}};
  for (const bool swarm : {false, true}) {
    const PrintedModels& printed = swarm ? kPrintedSwarm : kPrintedLeastSquares;
    for (const Condition& condition : kConditions) {
      const bool rising = condition.direction == id::Direction::kRising;
      const id::DiscreteModel& stated_model = printed.of(condition.direction);
      const Identified& identified = campaign.runs.front().*condition.identified;
      const id::DiscreteModel& ours = swarm ? identified.swarm.model : identified.least_squares;
      const std::string why = swarm ? why_of_swarm(condition, campaign, stated_model,
                                                   kPrintedLeastSquares.of(condition.direction))
                                    : why_of_least_squares(condition);
      const auto add = [&](const std::string& name, const char* unit, double stated, double found,
                           double tolerance) {
        part.findings.push_back({.item = swarm ? "(38)" : "(34)",
                                 .quantity = fmt::format("{}, {}, {}", name, printed.method, condition.name),
                                 .unit = unit,
                                 .paper = stated,
                                 .ours = found,
                                 .tolerance = tolerance,
                                 .why = why});
      };
      add(rising ? "b_0" : "b_1", "Pa/m", stated_model.b_Pa_m, ours.b_Pa_m, kLastOfB_Pa_m);
      for (std::size_t i = 0; i < 3; ++i) {
        add(fmt::format("a_{}", i + (rising ? 1 : 4)), "", stated_model.a[i], ours.a[i], kLastOfA);
      }
    }
  }
  for (const Condition& condition : kConditions) {
    const Identified& identified = campaign.runs.front().*condition.identified;
    report::XyChart chart = poles_chart(condition);
    for (const PrintedModels* printed : {&kPrintedLeastSquares, &kPrintedSwarm}) {
      chart.curves.push_back(
          poles_of(printed->of(condition.direction), fmt::format("{}, paper", printed->method)));
    }
    chart.curves.push_back(poles_of(identified.least_squares, "LS, ours"));
    chart.curves.push_back(poles_of(identified.swarm.model, "PSO, ours"));
    part.charts.emplace_back(std::move(chart));
  }
  return part;
}

}  // namespace plenum::host::reproduce::regulator_valve
