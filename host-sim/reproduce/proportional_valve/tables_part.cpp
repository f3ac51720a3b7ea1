#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "host-sim/plant/orifice.hpp"
#include "host-sim/reproduce/proportional_valve/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using identify::orifice::Flow;

constexpr double kPrintedArea_m2 = 7.85e-5;  // A_max
constexpr double kBore_m = 0.01;             // D_h
constexpr double kPrintedNeutral_V = 5.1;
constexpr double kPrintedCriticalRatio = 0.528;

// Rows of one series from shut to wide open.
std::vector<Row> towards_open(const Series& series) {
  std::vector<Row> rows = measured_rows(series);
  const bool opens_upwards = (series.flow == Flow::kCharge) == (series.channel == plant::MpyeChannel::a);
  if (!opens_upwards) std::reverse(rows.begin(), rows.end());
  return rows;
}

template <class Value>
double falling_steps(const std::vector<Row>& rows, const Value& value) {
  double count = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i)
    count += value(rows[i].truth) < value(rows[i - 1].truth) ? 1.0 : 0.0;
  return count;
}

// Flow at the start of a test, in square metres of choked area: A psi_e/psi_max at 1 against 7 bar.
double flow_at_start_m2(const plant::MpyeRow& row) {
  const plant::EllipsePort port{row.area_m2, row.critical_ratio, row.cracking_ratio, row.subsonic_index};
  return port.flux(kSupply_Pa, kAmbient_Pa).flow / kSupply_Pa;
}

// The command where the steep part of A(u), from 15 to 40 % of the greatest area, points at zero.
double points_at_zero_V(const Series& series) {
  const std::vector<Row> rows = towards_open(series);
  const double most = std::max_element(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
                        return a.truth.area_m2 < b.truth.area_m2;
                      })->truth.area_m2;
  double n = 0.0, u = 0.0, area = 0.0, uu = 0.0, ua = 0.0;
  for (const Row& row : rows) {
    if (row.truth.area_m2 < 0.15 * most || row.truth.area_m2 > 0.4 * most) continue;
    n += 1.0;
    u += row.command_V;
    area += row.truth.area_m2;
    uu += row.command_V * row.command_V;
    ua += row.command_V * row.truth.area_m2;
  }
  const double slope = (n * ua - u * area) / (n * uu - u * u);
  return (u - area / slope) / n;
}

std::string table(const Series& series) {
  return fmt::format("Table {}", series.number);
}

double outside_of_bounds() {
  double count = 0.0;
  for (const Series& series : all_series()) {
    for (const Row& row : measured_rows(series)) {
      const plant::MpyeRow& r = row.truth;
      const bool inside = r.area_m2 >= 0.0 && r.area_m2 <= 1e-2 && r.critical_ratio >= 0.0 &&
                          r.critical_ratio <= kPrintedCriticalRatio && r.subsonic_index >= 0.0 &&
                          r.subsonic_index <= 1.0 && r.cracking_ratio <= 1.0;
      count += inside ? 0.0 : 1.0;
    }
  }
  return count;
}

double least_cracking_ratio() {
  double least = 1.0;
  for (const Series& series : all_series()) {
    for (const Row& row : measured_rows(series)) least = std::min(least, row.truth.cracking_ratio);
  }
  return least;
}

// Rows of all tables whose b or beta stands at a bound of the fit.
int rows_at_a_bound() {
  int count = 0;
  for (const Series& series : all_series()) {
    for (const Row& row : measured_rows(series)) {
      const double b = row.truth.critical_ratio;
      if (b < 1e-12 || b >= kPrintedCriticalRatio || row.truth.subsonic_index >= 1.0) ++count;
    }
  }
  return count;
}

report::XyChart parameter_chart(const char* title, const char* symbol, double plant::MpyeRow::*value) {
  report::XyChart chart{.title = title, .caption = {}, .x = {"Command", "V"}, .y = {symbol, ""}};
  for (const Series& series : all_series()) {
    report::Curve curve{.name = table(series), .x = {}, .y = {}, .stroke = report::Stroke::kPoints};
    for (const Row& row : measured_rows(series)) {
      curve.x.push_back(row.command_V);
      curve.y.push_back(row.truth.*value);
    }
    chart.curves.push_back(curve);
  }
  return chart;
}

void add_table_1(Part& part) {
  part.findings.push_back({.item = "Table 1",
                           .quantity = "A_max from D_h",
                           .unit = "m2",
                           .paper = kPrintedArea_m2,
                           .ours = 0.25 * std::numbers::pi * kBore_m * kBore_m,
                           .tolerance = 5e-8});
  part.findings.push_back({.item = "Table 1",
                           .quantity = "psi_max",
                           .paper = 0.484,
                           .ours = plant::choked_flow_function(1.4),
                           .tolerance = 0.0005});
}

void add_bounds(Part& part) {
  part.findings.push_back({.item = "Results",
                           .quantity = "rows outside of the bounds of the fit",
                           .paper = 0.0,
                           .ours = outside_of_bounds(),
                           .source = Source::kPapersOwnEquation});
  part.findings.push_back({.item = "Tables 2 to 5",
                           .quantity = "least a, against atmosphere over supply",
                           .paper = kAmbient_Pa / kSupply_Pa,
                           .ours = least_cracking_ratio(),
                           .expect = Expect::kAtLeast,
                           .source = Source::kPapersOwnEquation});
}

void add_areas(Part& part) {
  for (const Series& series : all_series()) {
    const std::vector<Row> rows = towards_open(series);
    const double widest = std::max_element(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
                            return a.truth.area_m2 < b.truth.area_m2;
                          })->truth.area_m2;
    part.findings.push_back({.item = table(series),
                             .quantity = "greatest A, against A_max",
                             .unit = "m2",
                             .paper = kPrintedArea_m2,
                             .ours = widest,
                             .expect = Expect::kAtMost,
                             .source = Source::kPapersOwnEquation});
  }
  const double in_m2 = towards_open(all_series()[0]).back().truth.area_m2;
  const double out_m2 = towards_open(all_series()[1]).back().truth.area_m2;
  part.findings.push_back({.item = "Table 2",
                           .quantity = "A wide open, which C_d takes for A_max",
                           .unit = "m2",
                           .paper = kPrintedArea_m2,
                           .ours = in_m2,
                           .tolerance = 5e-8,
                           .source = Source::kPapersOwnEquation,
                           .why = "C_d = 0.575 follows from (5) by assuming that the maker's conductance "
                                  "holds for A_max, the same for both flow paths. With that C_d the wide "
                                  "open inlet should come out at A_max; Table 2 has half of it."});
  part.findings.push_back(
      {.item = "Fig. 6",
       .quantity = "A of exhaust over inlet, wide open, Channel A",
       .paper = 1.0,
       .ours = out_m2 / in_m2,
       .expect = Expect::kAtMost,
       .source = Source::kPapersOwnEquation,
       .why =
           fmt::format("The text lays the asymmetry to the silencer of the exhaust, which can only narrow "
                       "it; the exhaust is the wider by {:.2f}. Most of that is alpha: only A alpha is seen, "
                       "and with one alpha for both directions, instead of 1.4 and 1, the ratio is {:.2f}.",
                       out_m2 / in_m2, out_m2 / in_m2 / 1.4)});
}

void add_monotony(Part& part) {
  for (const Series& series : all_series()) {
    const std::vector<Row> rows = towards_open(series);
    part.findings.push_back(
        {.item = table(series),
         .quantity = "steps at which A falls as the valve opens",
         .paper = 0.0,
         .ours = falling_steps(rows, [](const plant::MpyeRow& row) { return row.area_m2; }),
         .source = Source::kPapersOwnEquation,
         .why = "Commands nearer to 0 or 10 V give larger openings, says Valve Operation. A falls wide open "
                "by the scatter of the fit, 1 to 2 %, and in the leak of the exhausts near 5 V, where the "
                "record covers ratios from 0.14 to a only and A stands for the flow at none of them."});
  }
  for (const Series& series : {all_series()[1], all_series()[3]}) {
    std::vector<Row> leak = towards_open(series);
    leak.resize(4);
    part.findings.push_back({.item = table(series),
                             .quantity = "steps at which the flow at 7 bar falls, first four rows",
                             .paper = 0.0,
                             .ours = falling_steps(leak, flow_at_start_m2),
                             .source = Source::kPapersOwnEquation,
                             .why = "The leak's flow at the start of the test, A psi_e, falls as well."});
  }
}

void add_neutral(Part& part) {
  const std::vector<Series>& all = all_series();
  for (const std::size_t first : {std::size_t{0}, std::size_t{2}}) {
    part.findings.push_back(
        {.item = "Fig. 6",
         .quantity = fmt::format("neutral command, Channel {}", first == 0 ? "A" : "B"),
         .unit = "V",
         .paper = kPrintedNeutral_V,
         .ours = 0.5 * (points_at_zero_V(all[first]) + points_at_zero_V(all[first + 1])),
         .tolerance = 0.05,
         .why = "Ours is midway between the commands at which the steep parts of the two areas (15 to 40 % "
                "of the greatest) point at zero. How the paper read its 5.1 V is not said."});
  }
}

}  // namespace

Part tables_part() {
  Part part;
  part.title = "Tables 1 to 5 against each other and the text";
  part.text = fmt::format(
      "The tables are the plant's data (plant/mpye_tables). 104 of their 204 rows were measured, 26 in each; "
      "{} of the 104 have b or beta at a bound of the fit (0 or 0.528, 1), where the value is the bound's "
      "and not the valve's: the text says that they remain within the bounds. The areas take C_d, alpha and "
      "V on their word, because a pressure record sees only their product.",
      rows_at_a_bound());
  add_table_1(part);
  add_bounds(part);
  add_areas(part);
  add_monotony(part);
  add_neutral(part);
  part.charts = {parameter_chart("Tables 2 to 5: critical ratio", "Critical pressure ratio b",
                                 &plant::MpyeRow::critical_ratio),
                 parameter_chart("Tables 2 to 5: cracking ratio", "Cracking pressure ratio a",
                                 &plant::MpyeRow::cracking_ratio),
                 parameter_chart("Tables 2 to 5: subsonic index", "Subsonic index beta",
                                 &plant::MpyeRow::subsonic_index)};
  return part;
}

}  // namespace plenum::host::reproduce::proportional_valve
