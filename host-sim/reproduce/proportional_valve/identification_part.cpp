#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "host-sim/reproduce/proportional_valve/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using FitOf = identify::orifice::OrificeFit IdentifiedRow::*;

// Half a unit of three printed digits, at worst; of a; two units of the last digit of b and beta.
constexpr double kArea_percent = 0.5;
constexpr double kCracking = 0.0005;
constexpr double kShape = 0.002;

double greatest(const IdentifiedSeries& series, const std::function<double(const IdentifiedRow&)>& off) {
  double most = 0.0;
  for (const IdentifiedRow& row : series.rows) most = greater_of(most, std::abs(off(row)));
  return most;
}

struct Why {
  std::string area, critical, cracking, index;
};

void add_recovery(Part& part, const IdentifiedSeries& series, FitOf fit, const Why& why) {
  const std::string item = fmt::format("Table {}", series.series.number);
  const auto add = [&](const char* quantity, const char* unit, double tolerance, const std::string& reason,
                       const std::function<double(const IdentifiedRow&)>& off) {
    part.findings.push_back({.item = item,
                             .quantity = quantity,
                             .unit = unit,
                             .paper = 0.0,
                             .ours = greatest(series, off),
                             .tolerance = tolerance,
                             .why = reason});
  };
  add("greatest error of A", "%", kArea_percent, why.area, [fit](const IdentifiedRow& r) {
    return 100.0 * ((r.*fit).area_m2->value / r.row.truth.area_m2 - 1.0);
  });
  add("greatest error of b", "", kShape, why.critical,
      [fit](const IdentifiedRow& r) { return (r.*fit).critical_ratio.value - r.row.truth.critical_ratio; });
  add("greatest error of a", "", kCracking, why.cracking,
      [fit](const IdentifiedRow& r) { return (r.*fit).cracking_ratio.value - r.row.truth.cracking_ratio; });
  add("greatest error of beta", "", kShape, why.index,
      [fit](const IdentifiedRow& r) { return (r.*fit).subsonic_index.value - r.row.truth.subsonic_index; });
}

// What biases the paper's method on records whose truth is known.
Why why_rate_fit_errs(identify::orifice::Flow flow) {
  const std::string rest =
      "The record ends a little before rest, where a is read, and noise moves its greatest ratio.";
  if (flow == identify::orifice::Flow::kCharge) {
    const std::string wide =
        "The wider open, the more: the vessel fills in as little as 60 ms, of which the moving average takes "
        "10 (without noise it alone gives 0.04 of beta, 0.3 % of A), and the noise of a full vessel counts "
        "as flow through a steep shape.";
    return {wide, wide, rest, wide};
  }
  const std::string leak = "Leak near 5 V: a is read too low before rest, and A and beta take the blame.";
  return {leak, "Wide open: the moving average rounds the onset of the subsonic flow.", rest, leak};
}

// "5.0 to 5.6 V, 7.4 V": the commands at which `which` holds.
std::string commands(const IdentifiedSeries& series, const std::function<bool(const IdentifiedRow&)>& which) {
  std::string text;
  for (std::size_t i = 0; i < series.rows.size();) {
    if (!which(series.rows[i])) {
      ++i;
      continue;
    }
    const std::size_t first = i;
    while (i < series.rows.size() && which(series.rows[i])) ++i;
    if (!text.empty()) text += ", ";
    text += first + 1 == i ? fmt::format("{:.1f}", series.rows[first].row.command_V)
                           : fmt::format("{:.1f} to {:.1f}", series.rows[first].row.command_V,
                                         series.rows[i - 1].row.command_V);
  }
  return text.empty() ? "none" : text + " V";
}

std::string not_identified(const std::vector<IdentifiedSeries>& all, FitOf fit) {
  std::string text;
  for (const IdentifiedSeries& series : all) {
    text += fmt::format(
        " Table {}: b {}; beta {}.", series.series.number,
        commands(series, [fit](const IdentifiedRow& r) { return !(r.*fit).critical_ratio.identified; }),
        commands(series, [fit](const IdentifiedRow& r) { return !(r.*fit).subsonic_index.identified; }));
  }
  return text;
}

report::XyChart area_chart(const char* channel, const IdentifiedSeries& charge,
                           const IdentifiedSeries& discharge, FitOf fit) {
  report::XyChart chart{
      .title = fmt::format("Fig. 6: effective orifice area, Channel {}", channel),
      .caption =
          "Dots: the paper's tables, which drove the simulated valve. Lines: identified from its vessel.",
      .x = {"Command", "V"},
      .y = {"Area A", "mm2"}};
  for (const IdentifiedSeries* series : {&charge, &discharge}) {
    const char* way = series == &charge ? "inlet" : "exhaust";
    report::Curve paper{.name = fmt::format("{}, Table {}", way, series->series.number),
                        .x = {},
                        .y = {},
                        .stroke = report::Stroke::kPoints,
                        .ink = report::Ink::kNeutral};
    report::Curve ours{.name = fmt::format("{}, identified", way), .x = {}, .y = {}};
    for (const IdentifiedRow& row : series->rows) {
      paper.x.push_back(row.row.command_V);
      paper.y.push_back(1e6 * row.row.truth.area_m2);
      ours.x.push_back(row.row.command_V);
      ours.y.push_back(1e6 * (row.*fit).area_m2->value);
    }
    chart.curves.push_back(paper);
    chart.curves.push_back(ours);
  }
  return chart;
}

report::XyChart bias_chart(const std::vector<IdentifiedSeries>& all, FitOf fit) {
  report::XyChart chart{.title = "Error of the subsonic index",
                        .caption = "Identified minus the value that drove the simulated valve.",
                        .x = {"Command", "V"},
                        .y = {"Error of beta", ""}};
  for (const IdentifiedSeries& series : all) {
    report::Curve curve{.name = fmt::format("Table {}", series.series.number), .x = {}, .y = {}};
    for (const IdentifiedRow& row : series.rows) {
      curve.x.push_back(row.row.command_V);
      curve.y.push_back((row.*fit).subsonic_index.value - row.row.truth.subsonic_index);
    }
    chart.curves.push_back(curve);
  }
  return chart;
}

report::XyChart standard_error_chart(const std::vector<IdentifiedSeries>& all, FitOf fit) {
  report::XyChart chart{
      .title = "Standard error of the critical ratio",
      .caption = "A gap: b is at a bound, and the record does not say how far beyond it would go.",
      .x = {"Command", "V"},
      .y = {.quantity = "Standard error of b", .unit = "", .logarithmic = true}};
  for (const IdentifiedSeries& series : all) {
    report::Curve curve{.name = fmt::format("Table {}", series.series.number), .x = {}, .y = {}};
    for (const IdentifiedRow& row : series.rows) {
      curve.x.push_back(row.row.command_V);
      curve.y.push_back((row.*fit).critical_ratio.standard_error);
    }
    chart.curves.push_back(curve);
  }
  return chart;
}

report::LineChart cycle_chart() {
  constexpr double kCharge_V = 6.2;
  constexpr double kDischarge_V = 4.0;
  report::LineChart chart{
      .title = "Fig. 5: Channel A, from the switch of the square wave to rest",
      .caption = "Ten simulated cycles averaged. The set points of the paper's figure are not printed.",
      .y = {"Vessel pressure", "kPa"}};
  for (const auto& [series, command_V] :
       {std::pair{all_series()[0], kCharge_V}, std::pair{all_series()[1], kDischarge_V}}) {
    const Experiment experiment = measure(series, command_V);
    report::Curve curve{.name = fmt::format("{:.1f} V", command_V), .x = experiment.record.time_s, .y = {}};
    for (const double p : experiment.record.vessel_Pa) curve.y.push_back(1e-3 * p);
    chart.curves.push_back(curve);
  }
  return chart;
}

}  // namespace

Part rate_fit_part(const IdentifiedValve& valve) {
  constexpr FitOf kFit = &IdentifiedRow::rate_fit;
  Part part;
  part.title = "Fig. 5 and 6, Tables 2 to 5: identified by the paper's method";
  part.text =
      "The rig of Fig. 4 is simulated with the tables as the valve: 0.4 L, 7 bar, square waves in 0.2 V "
      "steps, 1 kHz, 16 bits, noise of 0.2 kPa and a hum of 0.1 kPa at 100 Hz, ten cycles averaged, a moving "
      "average over ten samples, and (8) fitted to the discrete derivative within the paper's bounds, a at "
      "the greatest ratio recorded. What drove the valve should come back. The free run fitted instead, in "
      "the next part, has none of the bias seen here. Cannot be identified, because the fit ends at a "
      "bound:" +
      not_identified(valve.prompt, kFit);
  for (const IdentifiedSeries& series : valve.prompt)
    add_recovery(part, series, kFit, why_rate_fit_errs(series.series.flow));
  part.charts = {cycle_chart(), area_chart("A", valve.prompt[0], valve.prompt[1], kFit),
                 area_chart("B", valve.prompt[2], valve.prompt[3], kFit), bias_chart(valve.prompt, kFit)};
  return part;
}

Part pressure_fit_part(const IdentifiedValve& valve) {
  const std::string noise = "Noise of the simulated sensors beyond the printed digits.";
  constexpr FitOf kFit = &IdentifiedRow::pressure_fit;
  Part part;
  part.title = "Tables 2 to 5: identified from the pressure itself";
  part.text =
      "The same records; the free run of (7) is fitted to the unfiltered pressure, with a and the first "
      "pressure free. Tolerances: A half a unit of three digits, a half a unit, b and beta two units of the "
      "last printed digit. Cannot be identified, because the fit ends at a bound (0 or 0.528, 1), where "
      "noise decides which rows stay beside it:" +
      not_identified(valve.prompt, kFit);
  for (const IdentifiedSeries& series : valve.prompt)
    add_recovery(part, series, kFit, {noise, noise, noise, noise});
  part.charts = {bias_chart(valve.prompt, kFit), standard_error_chart(valve.prompt, kFit)};
  return part;
}

}  // namespace plenum::host::reproduce::proportional_valve
