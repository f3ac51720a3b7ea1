#include "host-sim/tools/diagnose_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host-sim/diagnose/found_rig.hpp"
#include "host-sim/effects/catalogue.hpp"
#include "host-sim/report/encoding.hpp"
#include "host-sim/tools/gap_text.hpp"
#include "host-sim/tools/model_charts.hpp"

namespace plenum::host::tools {
namespace {

using diagnose::CalibratedFigure;
using diagnose::Candidate;
using diagnose::Disturbance;
using diagnose::ErrorMap;
using diagnose::Estimate;
using diagnose::GapReport;
using diagnose::NamedEffect;
using diagnose::Trace;
using diagnose::Verdict;
using report::BarChart;
using report::Curve;
using report::HeatMap;
using report::Ink;
using report::LineChart;
using report::Mark;
using report::Page;
using report::Section;
using report::Stroke;
using report::Table;

double in_kPa(double pressure_Pa) {
  return to_three_digits(1e-3 * pressure_Pa);
}

double in_percent(double share) {
  return std::isfinite(share) ? std::round(1000.0 * share) / 10.0 : share;
}

/// "spool_lag: the valve's spool follows the command late"
std::string meaning_of(const std::string& id) {
  const auto found = effects::find(id);
  return found ? fmt::format("{}: {}", id, effects::kCatalogue[*found]->summary) : id;
}

std::string title_of(const GapReport& report) {
  if (report.traces.empty()) return "Simulated against measured";
  return report.traces.size() == 1 ? fmt::format("Simulated against measured: {}", report.traces.front().name)
                                   : fmt::format("Simulated against measured: {} logs", report.traces.size());
}

void add_tiles(Page& page, const GapReport& report) {
  std::vector<report::Tile> tiles{
      {"As configured", in_kPa(report.as_configured_Pa), "kPa", {}, "figures of the data sheet"},
      {"Recalibrated", in_kPa(report.recalibrated_Pa), "kPa", {}, "valve's figures fitted, no effect"},
      {"With effects", in_kPa(report.with_effects_Pa), "kPa", {}, "what is named below, added"},
      {report.baseline ? "Floor" : "Noise floor",
       in_kPa(report.noise_floor_Pa),
       "kPa",
       {},
       report.baseline ? "left of the baseline" : "no model does better"}};
  if (!report.effects.empty()) {
    tiles.push_back({"Closed", in_percent(report.closed_fraction), "%", {}, "of what was above the floor"});
  }
  page.tiles(tiles);
}

// ---- how far

/// The error left as calibration and then each effect is added. Shares of the squared error do not depend on the order.
void add_gap(Page& page, const GapReport& report) {
  std::vector<std::string> steps{"as configured", "recalibrated"};
  std::vector<double> left_kPa{in_kPa(report.as_configured_Pa), in_kPa(report.recalibrated_Pa)};
  const std::vector<NamedEffect> added = diagnose::effects_in_model(report);
  const double before = report.recalibrated_Pa * report.recalibrated_Pa;
  const double closed = before - report.with_effects_Pa * report.with_effects_Pa;
  double share = 0.0;
  for (std::size_t i = 0; i < added.size(); ++i) {
    share += added[i].share;
    const bool last = i + 1 == added.size();
    steps.push_back("with " + added[i].id);
    left_kPa.push_back(
        in_kPa(last ? report.with_effects_Pa : std::sqrt(std::max(before - share * closed, 0.0))));
  }
  steps.push_back(report.baseline ? "floor" : "noise floor");
  left_kPa.push_back(in_kPa(report.noise_floor_Pa));
  Section& section = page.section("The gap");
  if (report.baseline) {
    section.paragraph(
        "Asked is what has changed since: " + baseline_sentence(report) +
        " The valve's figures answer for baseline and logs together, effects for the logs alone.");
  }
  section
      .paragraph(fmt::format(
          "The model runs free: it starts from the first row of a log, is fed with the measured command and "
          "volume, and never sees the measured pressure again. The bars are its error on rows that no fit "
          "has "
          "seen. From the top: with the rig's figures {}, with the valve's figures fitted, with each effect "
          "added; at the bottom the floor: {}. Were there no gap, the recalibrated model would err as much "
          "with "
          "the probability {}.",
          report.baseline ? "as found on the baseline" : "as they are", floor_text(report), p_text(report)))
      .chart(BarChart{.title = "Error left, from configured to floor",
                      .categories = steps,
                      .value = {.quantity = "RMS error", .unit = "kPa", .min = 0.0},
                      .series = {{"RMS error", left_kPa}}});
}

// ---- which

Table effects_table(const GapReport& report) {
  Table table{.caption = "Effects named",
              .columns = {"Effect", "Confidence", "Share of what closes", "Error without [kPa]",
                          "Error with [kPa]", "Aliases"},
              .rows = {}};
  for (const NamedEffect& one : report.effects) {
    table.rows.push_back({one.id, percent(one.confidence), percent(one.share),
                          report::Fixed{1e-3 * one.gap_without_Pa, 3},
                          report::Fixed{1e-3 * one.gap_with_Pa, 3},
                          one.aliases.empty() ? std::string("none") : listed(one.aliases, "and")});
  }
  return table;
}

/// As the numbers of the table beside it are set.
std::string interval_cell(const Estimate& of) {
  return fmt::format("{} to {}{}", report::significant(of.low95), report::significant(of.high95),
                     of.at_bound ? ", at its bound" : "");
}

Table parameter_table(const GapReport& report) {
  Table table{.caption = "Parameters of the effects named",
              .columns = {"Effect", "Parameter and unit", "Value", "95 % interval"},
              .rows = {}};
  for (const NamedEffect& one : report.effects) {
    for (const Estimate& of : plain_parameters(one)) {
      table.rows.push_back({one.id, of.name, of.value, interval_cell(of)});
    }
  }
  return table;
}

/// Where the valve's null was found to be while the longest log ran.
LineChart null_chart(const NamedEffect& drift, const std::vector<Trace>& traces) {
  constexpr double kEvery_s = 0.1;
  effects::Figures figures = effects::neutral_figures();
  const std::size_t first = effects::kFirstFigure[effects::kIdNullDrift];
  const auto parameters = effects::kCatalogue[effects::kIdNullDrift]->parameters;
  for (const Estimate& of : drift.parameters) {
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      if (parameters[k].name == of.name) figures[first + k] = parameters[k].coordinate_of(of.value);
    }
  }
  double last_s = 0.0;
  for (const Trace& trace : traces) last_s = std::max(last_s, trace.time_s.back() - trace.time_s.front());
  effects::NullDrift<double> null;
  null.prepare(figures.data() + first, kEvery_s);
  const double begin_V = null.at(0.0);
  Curve moved{"null", {}, {}};
  for (double time_s = 0.0; time_s <= last_s; time_s += kEvery_s) {
    moved.x.push_back(std::round(10.0 * time_s) / 10.0);
    moved.y.push_back(to_three_digits(begin_V - null.at(0.0)));
    null.end_tick();
  }
  return {.title = "How far the valve's null has moved",
          .caption = "Found by the free run. From the first row of a log on.",
          .y = {"Shift", "V"},
          .curves = {moved}};
}

void add_ranking(Section& section, const GapReport& report) {
  if (report.candidates.empty()) return;
  std::vector<std::string> ids;
  std::vector<double> probability_percent;
  std::vector<double> left_kPa;
  for (const Candidate& one : report.candidates) {
    ids.push_back(one.id);
    probability_percent.push_back(in_percent(one.confidence));
    left_kPa.push_back(in_kPa(one.heldout_Pa));
  }
  section.paragraph(
      "Every effect of the catalogue was fitted alone, together with the valve's figures. Left: the "
      "probability that it is the cause, if one of them alone is. Right: the error that it leaves. A small "
      "error does not make a cause: an effect with more freedom fits almost anything a little, and an alias "
      "fits as well as the truth.");
  section.row({BarChart{.title = "Probability, if there is one cause",
                        .categories = ids,
                        .value = {.quantity = "Probability", .unit = "%", .min = 0.0, .max = 100.0},
                        .series = {{"probability", probability_percent}}},
               BarChart{.title = "Error left by each effect alone",
                        .caption = fmt::format("RMS, held out; recalibrated, without any effect: {}.",
                                               kPa_text(report.recalibrated_Pa)),
                        .categories = ids,
                        .value = {.quantity = "RMS error", .unit = "kPa", .min = 0.0},
                        .series = {{"RMS error", left_kPa}}}});
}

void add_cause(Page& page, const GapReport& report) {
  Section& section = page.section("The cause");
  switch (report.verdict) {
    case Verdict::none:
      section.paragraph("There is no gap beyond noise, and so no cause to look for.");
      break;
    case Verdict::calibration:
      section.paragraph(
          "The valve's figures, fitted, account for all of it. Effects that act just as one of these figures "
          "does, such "
          "as a volume error at fixed volume, are among what calibration takes up.");
      break;
    case Verdict::unexplained:
      section.note(
          "No effect of the catalogue, nor a set of them, closes the gap. None is named: look at where the "
          "model errs, and "
          "at the disturbance over time, for a cause that the catalogue does not have.");
      break;
    case Verdict::ambiguous:
      section.note(
          fmt::format("{}: rivals fit alike and are no sum; which one it is takes another experiment.",
                      fmt::join(causes_of(report), ", and ")));
      break;
    case Verdict::explained:
      section.paragraph(
          "With what is named here the error comes down to where it cannot be told from noise.");
      break;
    case Verdict::partly_explained:
      section.note(
          report.next
              ? "Part of the gap closes with what is named here, of which some are rivals, not a sum: the "
                "table says "
                "which. A rest beyond noise has another cause, which the catalogue may not have."
              : "What is named here closes part of the gap only: a rest beyond noise has another cause, "
                "which the catalogue may not have, and where that is large the name is no more sure than "
                "its confidence says.");
      break;
  }
  if (!report.effects.empty()) {
    std::vector<std::string> meanings;
    for (const NamedEffect& one : report.effects) meanings.push_back(meaning_of(one.id));
    section.list(meanings).table(effects_table(report));
    const Table parameters = parameter_table(report);
    if (!parameters.rows.empty()) section.table(parameters);
    for (const NamedEffect& one : diagnose::effects_in_model(report)) {
      if (one.id == effects::kNullDrift.id) section.chart(null_chart(one, report.traces));
    }
  }
  if (report.verdict != Verdict::none) add_ranking(section, report);
}

// ---- where

/// Rows from the top: the highest pressure first.
HeatMap error_map(const ErrorMap& map, const std::vector<std::vector<double>>& rms_Pa, double greatest_kPa,
                  std::string title) {
  HeatMap heat{.title = std::move(title),
               .row_quantity = "Pressure ratio",
               .rows = {},
               .column_quantity = "Command (V)",
               .columns = {},
               .value = {.quantity = "RMS error", .unit = "kPa", .min = 0.0, .max = greatest_kPa},
               .values = {}};
  for (const double command_V : map.command_V) heat.columns.push_back(fmt::format("{:.3g}", command_V));
  for (std::size_t row = map.pressure_ratio.size(); row-- > 0;) {
    heat.rows.push_back(fmt::format("{:.2g}", map.pressure_ratio[row]));
    heat.values.push_back(scaled(rms_Pa[row], 1e-3));
  }
  return heat;
}

/// The page's unit of a disturbance, and how many of it the disturbance's own is.
std::pair<std::string, double> shown_in(const std::string& unit) {
  if (unit == "Pa") return {"kPa", 1e-3};
  if (unit == "kg/s") return {"g/s", 1e3};
  if (unit.empty()) return {"% of the areas", 100.0};
  return {unit, 1.0};
}

/// In the units of the page.
std::string size_text(const Disturbance& of) {
  const auto [unit, many] = shown_in(of.unit);
  return fmt::format("{:.3g} {}", many * of.size, unit);
}

/// To the end of the last tick.
report::Axis time_axis(const Trace& trace) {
  const double first_s = trace.time_s.front();
  const double last_s = trace.time_s.back();
  const double tick_s = (last_s - first_s) / static_cast<double>(trace.time_s.size() - 1);
  return {.quantity = "Time", .unit = "s", .min = first_s, .max = std::round(1e4 * (last_s + tick_s)) / 1e4};
}

/// What the equation to blame would have to err by in the first log, tick by tick.
void add_disturbance(Section& section, const GapReport& report) {
  const auto blamed =
      std::find_if(report.disturbances.begin(), report.disturbances.end(),
                   [&](const Disturbance& one) { return one.equation == report.equation->equation; });
  if (blamed == report.disturbances.end() || blamed->smoothed.empty()) return;
  const Trace& trace = report.traces.front();
  const std::vector<double>& smoothed = blamed->smoothed.front();
  const auto ticks = static_cast<std::ptrdiff_t>(std::min(smoothed.size(), trace.time_s.size()));
  const auto [unit, many] = shown_in(blamed->unit);
  const std::vector<double> time_s(trace.time_s.begin(), trace.time_s.begin() + ticks);
  const std::vector<double> error = scaled({smoothed.begin(), smoothed.begin() + ticks}, many);
  section.chart(LineChart{
      .title = fmt::format("What the equation '{}' would err by, {}", blamed->equation, trace.name),
      .caption =
          "Were it alone to blame: the disturbance under which the recalibrated model follows the readings.",
      .x = time_axis(trace),
      .y = {"Disturbance", unit},
      .curves = {{"disturbance", time_s, error}},
      .group = trace.name});
}

void add_where(Page& page, const GapReport& report) {
  Section& section = page.section("Where");
  if (report.equation) {
    section.paragraph(
        fmt::format("The equation to blame is '{}' ({}): that of the effects, and as sure as they are, where "
                    "they close most of the gap, or else that whose disturbance explains the readings best.",
                    report.equation->equation, percent(report.equation->confidence)));
  }
  if (!report.disturbances.empty()) {
    Table table{.caption = "Before any cause: one equation at a time is given a disturbance",
                .columns = {"Equation", "Probability", "Size (RMS)", "Depends on", "Explained share"},
                .rows = {}};
    for (const auto& one : report.disturbances) {
      table.rows.push_back(
          {one.equation, percent(one.probability), size_text(one), one.depends_on, percent(one.dependence)});
    }
    section.table(table);
    if (report.equation) add_disturbance(section, report);
  }
  if (!report.where.empty()) {
    BarChart bars{.title = "Where the recalibrated model errs",
                  .caption = "Share of its squared error.",
                  .categories = {},
                  .value = {.quantity = "Share", .unit = "%", .min = 0.0},
                  .series = {{"share", {}}}};
    for (const auto& one : report.where) {
      bars.categories.push_back(one.regime);
      bars.series.front().values.push_back(in_percent(one.share));
    }
    section.chart(bars);
  }
  const ErrorMap& map = report.map;
  double greatest_kPa = 0.0;
  for (const auto& row : map.rms_Pa) {
    for (const double rms_Pa : row)
      greatest_kPa = std::max(greatest_kPa, std::isfinite(rms_Pa) ? in_kPa(rms_Pa) : 0.0);
  }
  if (greatest_kPa <= 0.0) return;
  if (report.effects.empty()) {
    section.paragraph(
        "The error over the command and the pressure ratio (p - ambient)/(supply - ambient); cells that the "
        "logs never "
        "visit are empty.");
    section.chart(error_map(map, map.rms_Pa, greatest_kPa, "Error of the recalibrated model"));
    return;
  }
  section.paragraph(
      "The error over the command and the pressure ratio (p - ambient)/(supply - ambient), on one scale "
      "before and after; "
      "cells that the logs never visit are empty.");
  section.row({error_map(map, map.rms_Pa, greatest_kPa, "Before: recalibrated"),
               error_map(map, map.closed_Pa, greatest_kPa, "After: with the effects named")});
}

// ---- over time

Curve error_curve(const std::string& name, const Trace& trace, const std::vector<double>& model_Pa) {
  Curve curve{name, trace.time_s, {}};
  for (std::size_t i = 0; i < model_Pa.size(); ++i) {
    curve.y.push_back(1e-3 * (model_Pa[i] - trace.measured_Pa[i]));
  }
  return curve;
}

void add_trace(Page& page, const GapReport& report, const Trace& trace) {
  const bool closed = !report.effects.empty();
  std::vector<Mark> heldout;
  std::string caption = "Fitted throughout.";
  if (trace.heldout_from < trace.time_s.size()) {
    caption = trace.heldout_from == 0 ? "Held out: no fit has seen it."
                                      : "Right of the mark: held out, no fit has seen it.";
    if (trace.heldout_from > 0) heldout = {{Mark::On::kX, trace.time_s[trace.heldout_from], "held out"}};
  }
  LineChart pressure{
      .title = fmt::format("Pressure, {}", trace.name),
      .caption = caption,
      .x = time_axis(trace),
      .y = {"Pressure", "kPa"},
      .curves = {{"measured", trace.time_s, scaled(trace.measured_Pa, 1e-3), Stroke::kSolid, Ink::kNeutral},
                 {"as configured", trace.time_s, scaled(trace.as_configured_Pa, 1e-3), Stroke::kSolid,
                  Ink::kFaint},
                 {"recalibrated", trace.time_s, scaled(trace.recalibrated_Pa, 1e-3)}},
      .marks = heldout,
      .group = trace.name};
  pressure.marks.push_back({Mark::On::kY, in_kPa(report.found.supply.pressure_Pa), "supply"});
  pressure.marks.push_back({Mark::On::kY, in_kPa(report.found.ambient.pressure_Pa), "ambient"});
  LineChart error{.title = fmt::format("Error, {}", trace.name),
                  .caption = "Model minus measured.",
                  .x = time_axis(trace),
                  .y = {"Error", "kPa"},
                  .curves = {error_curve("recalibrated", trace, trace.recalibrated_Pa)},
                  .marks = heldout,
                  .group = trace.name};
  if (closed) {
    pressure.curves.push_back({"with effects", trace.time_s, scaled(trace.with_effects_Pa, 1e-3)});
    error.curves.push_back(error_curve("with effects", trace, trace.with_effects_Pa));
  }
  Section& section = page.section(fmt::format("Measured against model: {}", trace.name));
  section.chart(pressure).chart(error).chart(
      LineChart{.title = fmt::format("Command, {}", trace.name),
                .x = time_axis(trace),
                .y = {"Command", "V"},
                .curves = {{"command", trace.time_s, trace.command_V, Stroke::kSteps}},
                .group = trace.name});
  if (!trace.disturbance_kg_s.empty()) {
    section.chart(LineChart{
        .title = fmt::format("Disturbance, {}", trace.name),
        .caption = "The flow that, added to the chamber, would make the recalibrated model follow the "
                   "measurement: what is missing, before it has a name.",
        .x = time_axis(trace),
        .y = {"Flow", "g/s"},
        .curves = {{"disturbance", trace.time_s, scaled(trace.disturbance_kg_s, 1e3)}},
        .group = trace.name});
  }
}

// ---- calibration, and what the logs cannot tell

void add_calibration(Page& page, const GapReport& report) {
  if (report.calibration.empty()) return;
  const bool closed = !report.effects.empty();
  Table table{.caption = "Figures of the valve",
              .columns = {"Figure", "Configured", "Recalibrated", "95 % interval", "Change [%]"},
              .rows = {}};
  if (closed) table.columns.push_back("With the effects named");
  for (const CalibratedFigure& one : report.calibration) {
    const double change = 100.0 * (one.fitted.value / one.configured - 1.0);
    table.rows.push_back(
        {one.name, one.configured, one.fitted.value, interval_cell(one.fitted), to_three_digits(change)});
    if (closed) table.rows.back().emplace_back(one.with_effects);
  }
  Section& section = page.section("Calibration");
  section.paragraph(
      "The figures that calibration may change. One whose interval is wide, or that ends at its bound, is "
      "not shown by "
      "these logs.");
  if (closed) {
    section.paragraph(
        "Without the effects named, these figures bend to make up for them: the last column is what the "
        "valve has once "
        "they are in the model.");
  }
  if (const std::string stamps = stamps_sentence(report); !stamps.empty()) section.paragraph(stamps);
  section.table(table);
}

void add_limits(Page& page, const GapReport& report) {
  Section& section = page.section("What these logs can and cannot tell");
  if (report.next) section.note(fmt::format("Next experiment: {}", next_text(report)));
  if (report.alias_classes.empty()) {
    section.paragraph(
        "This excitation can tell every effect of the catalogue from every other, however small.");
  } else {
    std::vector<std::string> classes;
    for (const auto& of : report.alias_classes) classes.push_back(listed(of, "and"));
    section
        .paragraph(
            "While they are small, these cannot be told from each other by this excitation, whatever was "
            "measured; what stands with calibration looks like other figures of the valve:")
        .list(classes);
  }
  if (report.detectable.empty()) return;
  Table table{.caption = "Size at which each effect would just have shown (5 % false alarms, 95 % power)",
              .columns = {"Effect", "Parameter and unit", "Just shown at"},
              .rows = {}};
  for (const auto& one : report.detectable) {
    table.rows.push_back({one.id, one.parameter, to_three_digits(one.smallest)});
  }
  section.paragraph("Beside the model above another effect may still be there, but weaker than this:")
      .table(table);
}

}  // namespace

Page diagnose_page(const GapReport& report) {
  Page page(title_of(report));
  page.lead(verdict_sentence(report));
  add_tiles(page, report);
  add_gap(page, report);
  add_cause(page, report);
  add_where(page, report);
  for (const Trace& trace : report.traces) add_trace(page, report, trace);
  add_calibration(page, report);
  add_limits(page, report);
  return page;
}

}  // namespace plenum::host::tools
