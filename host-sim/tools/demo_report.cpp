#include "host-sim/tools/demo_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host-sim/tools/gap_text.hpp"
#include "host-sim/tools/model_charts.hpp"
#include "host-sim/trace/model_json.hpp"

namespace plenum::host::tools {
namespace {

using report::Curve;
using report::Ink;
using report::LineChart;
using report::Stroke;

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
constexpr double kShown_s = 10.0;  ///< of a recording
constexpr std::size_t kChangeRows = 200;

std::string chamber_name(std::size_t chamber) {
  return fmt::format("ch. {}", chamber + 1);
}

trace::Log first_rows(const trace::Log& log, std::size_t count) {
  trace::Log cut = log;
  for (auto* column : {&cut.time_s, &cut.command_V, &cut.pressure_Pa, &cut.volume_m3, &cut.reference_Pa})
    column->resize(std::min(column->size(), count));
  return cut;
}

/// Chambers with the least and the largest value.
template <class Value>
std::pair<std::size_t, std::size_t> best_and_worst(std::size_t count, Value value) {
  std::size_t best = 0;
  std::size_t worst = 0;
  for (std::size_t c = 1; c < count; ++c) {
    if (value(c) < value(best)) best = c;
    if (value(c) > value(worst)) worst = c;
  }
  return {best, worst};
}

LineChart held_out_chart(const Demo& demo, std::size_t chamber) {
  const DemoChamber& of = demo.chamber[chamber];
  const trace::Log log =
      first_rows(of.held_out, static_cast<std::size_t>(kShown_s / of.held_out.period_s) + 1);
  return free_run_chart(
      of.fit.model, log, fmt::format("Free runs, {}", chamber_name(chamber)),
      fmt::format("RMS error over the whole held-out record: {:.1f} kPa.", of.free_run_rms_kPa));
}

/// Fig. 11: how far the pressure moves in one tick.
LineChart change_chart(const Demo& demo, std::size_t chamber) {
  const DemoChamber& of = demo.chamber[chamber];
  const trace::Log& log = of.held_out;
  Curve measured{"measured", {}, {}, Stroke::kSolid, Ink::kNeutral};
  Curve predicted{"predicted one tick ahead", {}, {}};
  for (std::size_t k = 2; k < std::min(kChangeRows + 2, log.size() - 1); ++k) {
    const double next_Pa = identify::predict_free_run(of.fit.model, log, k, 1).front();
    measured.x.push_back(log.time_s[k]);
    measured.y.push_back((log.pressure_Pa[k + 1] - log.pressure_Pa[k]) / 1e3);
    predicted.x.push_back(log.time_s[k]);
    predicted.y.push_back((next_Pa - log.pressure_Pa[k]) / 1e3);
  }
  return {.title = fmt::format("Pressure change in one tick, {}", chamber_name(chamber)),
          .caption = fmt::format("RMS error of the prediction on the fitted record: {:.2f} kPa.",
                                 of.fit.rms_one_step_kPa),
          .y = {"Change in 10 ms", "kPa"},
          .curves = {measured, predicted}};
}

/// Fig. 13: how the error of a free run grows.
LineChart drift_chart(const Demo& demo) {
  LineChart chart{.title = "Drift of free runs, all chambers",
                  .caption =
                      "Standard deviation over 48 starts of the error of a free run, against the time "
                      "since its start.",
                  .x = {"Time since start", "s"},
                  .y = {"Standard deviation", "% of span"}};
  for (std::size_t c = 0; c < demo.chamber.size(); ++c) {
    const identify::Drift& drift = demo.chamber[c].drift;
    chart.curves.push_back({chamber_name(c), drift.time_s, drift.std_percent});
  }
  return chart;
}

std::vector<ModelCurve> model_curves(const Demo& demo) {
  std::vector<ModelCurve> curves;
  for (std::size_t c = 0; c < demo.chamber.size(); ++c) {
    const DemoChamber& of = demo.chamber[c];
    curves.push_back({chamber_name(c), of.fit.model, 1e6 * of.held_out.mean_volume_m3()});
  }
  return curves;
}

report::Row tracking_charts(const DemoTracked& tracked, std::size_t chamber) {
  std::vector<double> time_s, reference_kPa, pressure_kPa, command_V;
  for (const client::CapturedRow& row : tracked.rows) {
    time_s.push_back(row.time_s);
    reference_kPa.push_back(row.reference_Pa[chamber] / 1e3);
    pressure_kPa.push_back(row.sample[chamber].actual_Pa / 1e3);
    command_V.push_back(row.sample[chamber].command_V);
  }
  const client::Tracking& how = tracked.chamber[chamber];
  std::string caption =
      fmt::format("RMS error {:.2f} kPa, worst {:.1f} kPa.", how.rmse_Pa / 1e3, how.worst_Pa / 1e3);
  return {{LineChart{.title = fmt::format("{}, {}", tracked.name, chamber_name(chamber)),
                     .caption = caption,
                     .y = {"Pressure", "kPa"},
                     .curves = {{"reference", time_s, reference_kPa, Stroke::kDashed, Ink::kNeutral},
                                {"measured pressure", time_s, pressure_kPa}},
                     .group = tracked.name},
           LineChart{.title = fmt::format("Command, {}, {}", tracked.name, chamber_name(chamber)),
                     .y = {"Command", "V"},
                     .curves = {{"command", time_s, command_V, Stroke::kSteps}},
                     .group = tracked.name}}};
}

report::Table tracking_table(const Demo& demo) {
  report::Table table{.caption = "RMS tracking error [kPa]", .columns = {"Reference"}, .rows = {}};
  for (std::size_t c = 0; c < demo.chamber.size(); ++c) table.columns.push_back(chamber_name(c));
  for (const DemoTracked& tracked : demo.tracked) {
    std::vector<report::Cell> row{tracked.name};
    for (const client::Tracking& one : tracked.chamber) row.emplace_back(report::Fixed{one.rmse_Pa / 1e3, 2});
    table.rows.push_back(row);
  }
  return table;
}

report::Table parameter_table(const Demo& demo) {
  report::Table table{
      .caption =
          "Parameters and their standard errors (↓ ↑: at the lower, upper bound, where there is "
          "none)",
      .columns = {"Parameter"},
      .rows = {}};
  for (std::size_t c = 0; c < demo.chamber.size(); ++c) table.columns.push_back(chamber_name(c));
  for (std::size_t i = 0; i < identify::kFree; ++i) {
    std::vector<report::Cell> row{std::string(trace::kTassa9Names[i])};
    for (const DemoChamber& chamber : demo.chamber) {
      row.emplace_back(parameter_cell(chamber.fit.parameters[i]));
    }
    table.rows.push_back(row);
  }
  std::vector<report::Cell> widths{std::string(trace::kTassa9Names[identify::kFree])};
  std::vector<report::Cell> dead_times{std::string("dead_time_s")};
  std::vector<report::Cell> conditions{std::string("condition")};
  for (const DemoChamber& chamber : demo.chamber) {
    widths.emplace_back(fmt::format("{:g}", chamber.fit.model.c_gamma_V));
    dead_times.emplace_back(parameter_cell(chamber.fit.dead_time));
    conditions.emplace_back(fmt::format("{:.0f}", chamber.fit.condition));
  }
  table.rows.push_back(widths);
  table.rows.push_back(dead_times);
  table.rows.push_back(conditions);
  return table;
}

/// Why free runs drift on this rig.
std::string drift_note(const Demo& demo) {
  std::string text =
      "The models in use are fitted to free runs of 0.2 s, which regulates better than a "
      "fit to 2 s and drifts more.";
  if (demo.measured_valves) {
    text +=
        " The valves follow measured tables with a dead band of more than 1 V, where nine parameters "
        "only come close.";
  }
  if (demo.volume_swing > 0.0) {
    text +=
        " The volumes move, and there the published model is wrong: it shifts the steady pressure by "
        "c4 v' whatever the pressure is, while in the physics compression acts as -kappa p v'/v. No "
        "fit can remove that; run with --volume-swing 0 to see what remains.";
  }
  return text;
}

/// What the standard errors and c_gamma mean on this rig.
std::string parameter_note(const Demo& demo) {
  std::string text =
      "Standard errors take the prediction errors as white noise; where the model does not "
      "fit they are lower bounds. c_gamma, the width of the kink at the null, is chosen "
      "among 0.1 (the paper's), 0.2, 0.4, 0.8 and 1.6 V by the free-run error.";
  if (demo.measured_valves) {
    text += " These valves have a dead band of more than 1 V, and the paper's value is far off on them.";
  }
  return text;
}

void add_prediction(report::Page& page, const Demo& demo) {
  const auto [best, worst] = best_and_worst(
      demo.chamber.size(), [&](std::size_t c) { return demo.chamber[c].drift.worst_std_percent; });
  page.section("Prediction in free run")
      .paragraph(
          "The model gets the measured command and volume, and from the start of each run on carries its "
          "own pressure along; every 2 s it starts again from the measurement. The record is one that no "
          "fit has seen. The paper's Fig. 12 shows the same for one chamber of its robot, and hardly any "
          "drift.")
      .row({held_out_chart(demo, best), held_out_chart(demo, worst)})
      .paragraph(
          "Left the chamber that drifts least, right the one that drifts most. Here the runs do part: "
          "errors add up because nothing pulls a free run back. The regulator looks two ticks ahead and is "
          "corrected by the measurement at each of them, which is why it follows so much better than this "
          "prediction does.");
  page.section("Drift")
      .paragraph(
          "The error of free runs against the time since their start. The paper's Fig. 13, of 76 chambers, "
          "stays below 10 % of span and mostly below 4 %. A curve that levels off means that the model "
          "errs, but does not run away.")
      .chart(drift_chart(demo))
      .note(drift_note(demo));
  const auto [near, far] = best_and_worst(
      demo.chamber.size(), [&](std::size_t c) { return demo.chamber[c].fit.rms_one_step_kPa; });
  page.section("One tick ahead")
      .paragraph(
          "How far the pressure moves within one tick of 10 ms, measured and predicted: what the regulator "
          "inverts. "
          "The paper says of its Fig. 11 that the main features are captured. So they are here, but high "
          "peaks come out "
          "too low, and while a pressure is held the model may expect it to move by a few kPa a tick; the "
          "board's "
          "disturbance estimate takes that out.")
      .row({change_chart(demo, near), change_chart(demo, far)});
}

void add_models(report::Page& page, const Demo& demo) {
  constexpr CommandRange kCommands{3.0, 7.0};
  const std::vector<ModelCurve> curves = model_curves(demo);
  page.section("The models")
      .paragraph(
          "A chamber's pressure goes to s with rate r: p' = (s - p) r. Both depend on the command u; s "
          "rises from ambient to supply pressure around the valve's null, r has its minimum there, where "
          "both ports are nearly shut. Larger chambers have the smaller r.")
      .chart(steady_chart(curves, kCommands, "Volume at its mean and at rest."))
      .chart(rate_chart(curves, kCommands, "Volume at its mean and at rest. Smallest at the valve's null."))
      .table(parameter_table(demo))
      .note(parameter_note(demo));
}

void add_tracking(report::Page& page, const Demo& demo) {
  report::Section& overview = page.section("Tracking");
  overview.paragraph(
      "The board inverts the model at each tick for the command that brings the pressure to the reference "
      "one tick later, knows the reference two ticks ahead from the set-point stream, and removes what the "
      "model misses by a disturbance estimate. Everything crosses the simulated CAN bus: set points at 100 "
      "Hz to the board, pressures back. The first half second of each reference is left out of the figures.");
  overview.table(tracking_table(demo));
  report::BarChart bars{.title = "Tracking error by chamber",
                        .caption = "Steps are left out: no valve can follow a jump.",
                        .categories = {},
                        .value = {"RMS error", "kPa"},
                        .series = {}};
  for (std::size_t c = 0; c < demo.chamber.size(); ++c) bars.categories.push_back(chamber_name(c));
  for (const DemoTracked& tracked : demo.tracked) {
    if (tracked.shape.kind == client::ReferenceKind::steps) continue;
    report::BarChart::Bars series{tracked.name, {}};
    for (const client::Tracking& one : tracked.chamber) series.values.push_back(one.rmse_Pa / 1e3);
    bars.series.push_back(series);
  }
  overview.chart(bars);

  report::Section& curves = page.section("References and commands");
  curves.paragraph(
      "For each reference the chamber that follows it worst: the others do better. Where the command rests "
      "at 3 or 7 V the valve gives all it has, and what error is left there belongs to the valve and not to "
      "the model. Bursts in which it leaps to and fro, while the pressure is held or turns, are no such "
      "limit: there the regulator chatters.");
  for (const DemoTracked& tracked : demo.tracked) {
    const auto [best, worst] =
        best_and_worst(tracked.chamber.size(), [&](std::size_t c) { return tracked.chamber[c].rmse_Pa; });
    curves.row(tracking_charts(tracked, worst).charts);
  }
}

std::string figures_text(const DemoGap& gap) {
  std::string text;
  for (const auto& [name, value] : gap.figures)
    text += fmt::format("{}{} {:g}", text.empty() ? "" : ", ", name, value);
  return text;
}

std::string found_text(const DemoGap& gap) {
  std::string text;
  for (const diagnose::NamedEffect& effect : gap.report.effects) {
    if (!text.empty()) text += "; ";
    text += fmt::format("{} {}: ", effect.id, percent(effect.confidence));
    for (std::size_t i = 0; i < effect.parameters.size(); ++i)
      text += (i > 0 ? ", " : "") + text_of(effect.parameters[i]);
  }
  return text.empty() ? "nothing" : text;
}

LineChart gap_chart(const DemoGap& gap) {
  constexpr double kTick_s = 0.01;
  Curve before{"with the data sheet's model", {}, {}};
  Curve after{"with the model found", {}, {}};
  for (std::size_t k = client::kOnsetRows; k < gap.before.error_Pa.size(); ++k) {
    before.x.push_back(kTick_s * static_cast<double>(k));
    before.y.push_back(gap.before.error_Pa[k] / 1e3);
    after.y.push_back(gap.after.error_Pa[k] / 1e3);
  }
  after.x = before.x;
  return {.title = fmt::format("Tracking error, {}", gap.effect),
          .caption = gap.uploaded ? fmt::format("RMS {:.2f} kPa before, {:.2f} kPa after.",
                                                gap.before.rms_Pa / 1e3, gap.after.rms_Pa / 1e3)
                                  : "The board kept its model: " + gap.refusal,
          .y = {"Error", "kPa"},
          .curves = {before, after},
          .group = "gaps"};
}

void add_gaps(report::Page& page, const Demo& demo) {
  report::Section& section = page.section("What the data sheet does not state");
  section.paragraph(
      "One chamber each behind a thin-plate valve of the same data sheet, and in each machine one effect "
      "that the "
      "sheet does not state. The board excites the chamber for 20 s; the diagnosis gets this recording and "
      "the sheet, "
      "finds which effect the model lacks, and how large it is. What it finds goes to the board as a "
      "grey-box model, "
      "and the board follows one random reference before and after, each time with the same estimates of "
      "what its "
      "model misses: where these alone make up for an effect, there is little left to gain.");
  report::Table table{
      .caption =
          "Effects, withheld from the diagnosis, and what is made of them; errors in kPa RMS with the data "
          "sheet's model and with the one found",
      .columns = {"The machine has", "The diagnosis says, with 95 % intervals", "Model error, sheet",
                  "Model error, found", "Tracking error, sheet", "Tracking error, found"},
      .rows = {}};
  report::BarChart bars{.title = "Tracking error before and after",
                        .caption = "True pressure less reference, RMS.",
                        .categories = {},
                        .value = {"RMS error", "kPa"},
                        .series = {{"with the data sheet's model", {}}, {"with the model found", {}}}};
  for (const DemoGap& gap : demo.gaps) {
    table.rows.push_back({fmt::format("{}: {}", gap.effect, figures_text(gap)), found_text(gap),
                          report::Fixed{gap.report.as_configured_Pa / 1e3, 2},
                          report::Fixed{gap.report.with_effects_Pa / 1e3, 2},
                          report::Fixed{gap.before.rms_Pa / 1e3, 2},
                          report::Fixed{gap.after.rms_Pa / 1e3, 2}});
    bars.categories.push_back(gap.effect);
    bars.series[0].values.push_back(to_hundredths(gap.before.rms_Pa / 1e3));
    bars.series[1].values.push_back(to_hundredths(gap.after.rms_Pa / 1e3));
  }
  section.table(table);
  section.chart(bars);
  for (std::size_t i = 0; i < demo.gaps.size(); i += 2) {
    std::vector<report::Chart> charts{gap_chart(demo.gaps[i])};
    if (i + 1 < demo.gaps.size()) charts.emplace_back(gap_chart(demo.gaps[i + 1]));
    section.row(charts);
  }
}

}  // namespace

double smooth_rmse_kPa(const Demo& demo) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const DemoTracked& tracked : demo.tracked) {
    if (tracked.shape.kind == client::ReferenceKind::steps) continue;
    for (const client::Tracking& one : tracked.chamber) {
      sum += one.rmse_Pa * one.rmse_Pa;
      ++count;
    }
  }
  return 1e-3 * std::sqrt(sum / static_cast<double>(count));
}

double worst_drift_percent(const Demo& demo) {
  double worst = 0.0;
  for (const DemoChamber& chamber : demo.chamber) worst = std::max(worst, chamber.drift.worst_std_percent);
  return worst;
}

report::Page demo_page(const Demo& demo) {
  report::Page page(fmt::format("{} chambers, identified and regulated over CAN", demo.chamber.size()));
  page.lead(fmt::format(
      "A simulated board with {} valves {}, and chambers {}. Everything below crossed the simulated CAN "
      "bus: recording, models, set points.",
      demo.chamber.size(), demo.measured_valves ? "that follow measured tables" : "of thin-plate orifices",
      demo.volume_swing > 0.0 ? fmt::format("whose volumes move by {:.0f} %", 100.0 * demo.volume_swing)
                              : "with volumes at rest"));
  double overshoot_Pa = 0.0;
  double settling_s = 0.0;
  for (const DemoTracked& tracked : demo.tracked) {
    for (const client::Tracking& one : tracked.chamber) {
      if (std::isnan(one.overshoot_Pa)) continue;
      overshoot_Pa = std::max(overshoot_Pa, one.overshoot_Pa);
      settling_s = std::isnan(one.settling_s) ? kGap : std::max(settling_s, one.settling_s);
    }
  }
  page.tiles(
      {{"Tracking, RMS",
        to_hundredths(1e5 * smooth_rmse_kPa(demo) / demo.span_Pa),
        "% of span",
        {},
        fmt::format("{:.2f} kPa; all references but steps", smooth_rmse_kPa(demo))},
       {"Overshoot of steps",
        to_hundredths(100.0 * overshoot_Pa / demo.span_Pa),
        "% of span",
        {},
        "worst chamber"},
       {"Settling of steps", settling_s, "s", {}, "to 1 % of span, slowest"},
       {"Drift of free runs",
        to_hundredths(worst_drift_percent(demo)),
        "% of span",
        {},
        "worst chamber, up to 2 s"},
       {"Models on the board", static_cast<double>(demo.chamber.size()), "", {}, "each read back identical"},
       {"Bus load", to_hundredths(100.0 * demo.bus_load), "%", {}, "of 1 Mbit/s, mean"}});
  add_tracking(page, demo);
  if (!demo.gaps.empty()) add_gaps(page, demo);
  add_prediction(page, demo);
  add_models(page, demo);
  page.section("How this was made")
      .list({fmt::format(
                 "Rig: supply {:.0f} kPa, ambient {:.0f} kPa, seed {}: the same seed repeats every bit.",
                 demo.rig.supply.pressure_Pa / 1e3, demo.rig.ambient.pressure_Pa / 1e3, demo.seed),
             fmt::format(
                 "First recording: {:g} s, the board excites its valves at random within pressure limits.",
                 demo.record_s),
             fmt::format("Second: {:g} s, regulated with the first models to random references; it gives the "
                         "models in use, because its commands are those of regulation.",
                         demo.record_s),
             "Third: as the second with another seed, for prediction only.",
             fmt::format("Bus: {} frames in {:.0f} s of simulated time, {:.1f} % of 1 Mbit/s.",
                         demo.bus_frames, demo.simulated_s, 100.0 * demo.bus_load)});
  return page;
}

}  // namespace plenum::host::tools
