// A relief valve from its pressure-flow curve at rest, and its lag from transients: the grey box in two stages.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/relief_valve/dynamic_fit.hpp"
#include "host-sim/identify/relief_valve/static_fit.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/tools/arguments.hpp"
#include "host-sim/tools/bench_input.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/figures.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"

namespace plenum::host::tools {
namespace {

namespace relief = identify::relief_valve;
using plant::relief_valve::GreyBoxConfig;
using plant::relief_valve::StaticGreyBox;
using relief::StaticPoint;
using relief::Transient;

constexpr double kShut = 0.01;     // of the greatest flow: below it a valve counts as shut
constexpr double kLeast_Pa = 1e3;  // of a hydraulic valve; less is another unit
constexpr double kGreatest_Pa = 2e8;
constexpr double kGreatest_m3_s = 1.0;  // 60,000 L/min; more is another unit
constexpr double kLitreMinute = 6e4;
constexpr double kShortestLag_s = 1e-5;
constexpr double kLongestLag_s = 10.0;
constexpr std::size_t kDrawn = 200;  // points of a curve

struct Options {
  std::string curve;
  std::vector<std::string> transients;
  std::vector<std::string> held_out;
  double density_kg_m3 = 865.0;
  std::string report;
  Output output;
};

void require_units(const trace::Recording& of, double least_m3_s, const std::string& expected_flow) {
  require_between(of, "pressure_drop_Pa", kLeast_Pa, kGreatest_Pa,
                  "the pressure above the tank's in Pa, 1e3 to 2e8");
  require_between(of, "flow_m3_s", least_m3_s, kGreatest_m3_s, expected_flow);
}

/// The points of a curve that flow, by rising flow.
std::vector<StaticPoint> open_points(const trace::Recording& curve) {
  const std::vector<double>& flow_m3_s = curve["flow_m3_s"];
  const double shut_m3_s = kShut * *std::max_element(flow_m3_s.begin(), flow_m3_s.end());
  std::vector<StaticPoint> points{};
  for (std::size_t i = 0; i < curve.rows; ++i) {
    if (flow_m3_s[i] > shut_m3_s) points.push_back({curve["pressure_drop_Pa"][i], flow_m3_s[i]});
  }
  if (points.empty())
    throw identify::CannotIdentify(fmt::format("{}: the valve never opens: no flow", curve.name));
  std::sort(points.begin(), points.end(),
            [](const StaticPoint& a, const StaticPoint& b) { return a.flow_m3_s < b.flow_m3_s; });
  return points;
}

struct Curve {
  std::string name;
  std::size_t shut = 0;  ///< points left out
  std::vector<StaticPoint> points{};
  StaticGreyBox line{};  ///< (3.15)
  relief::StaticError line_error{};
  StaticGreyBox bent{};  ///< (3.12), where the flow force is above 0; else the line
  relief::StaticError bent_error{};
  bool has_flow_force = false;
  double worst = 0.0;           ///< largest error of pressure, of the pressure
  double held_out_worst = 0.0;  ///< of each third point, fitted to the others
};

/// (3.12), or (3.15) where these points ask for a flow force that pulls the valve open.
StaticGreyBox fit_bent(const std::vector<StaticPoint>& points, double density_kg_m3) {
  const StaticGreyBox bent = relief::fit_static(points, density_kg_m3);
  return bent.k2_s_m_sqrtPa > 0.0 ? bent
                                  : relief::fit_static(points, density_kg_m3, relief::FlowForce::kLeftOut);
}

Curve fit_curve(const Options& options) {
  const trace::Recording log = read_bench("relief", options.curve, {"pressure_drop_Pa", "flow_m3_s"});
  require_units(log, -0.1 * kGreatest_m3_s, "m3/s, 1 at most");
  Curve curve{.name = log.name, .points = open_points(log)};
  curve.shut = log.rows - curve.points.size();
  std::vector<StaticPoint> kept;
  std::vector<StaticPoint> held_out;
  for (std::size_t i = 0; i < curve.points.size(); ++i)
    (i % 3 == 1 ? held_out : kept).push_back(curve.points[i]);
  told_of(curve.name, [&] {
    curve.line = relief::fit_static(curve.points, options.density_kg_m3, relief::FlowForce::kLeftOut);
    curve.line_error = relief::static_error(curve.line, curve.points, relief::FlowForce::kLeftOut);
    curve.bent = fit_bent(curve.points, options.density_kg_m3);
    curve.has_flow_force = curve.bent.k2_s_m_sqrtPa > 0.0;
    curve.bent_error =
        curve.has_flow_force ? relief::static_error(curve.bent, curve.points) : curve.line_error;
    curve.held_out_worst = relief::worst_pressure_error(fit_bent(kept, options.density_kg_m3), held_out);
  });
  curve.worst = relief::worst_pressure_error(curve.bent, curve.points);
  return curve;
}

struct Run {
  std::string name;
  Transient whole{};
  std::size_t held_out_from = 0;  ///< row; what is before was fitted
  std::vector<double> predicted_Pa{};
  std::vector<double> static_Pa{};  ///< by the line alone
  double worst = 0.0;               ///< largest error of the held-out rows, of the pressure
  double static_worst = 0.0;
  double of_swing = 0.0;  ///< the same error of the swing of pressure in the whole run
  double final = 0.0;     ///< mean of the last tenth, of the pressure

  std::vector<double> time_s() const { return times_s(whole.pressure_Pa.size(), whole.step_s); }
  double held_out_s() const { return whole.step_s * static_cast<double>(held_out_from); }
};

Run read_run(const std::string& file, double held_out) {
  const trace::Recording log = read_bench("relief", file, {"time_s", "pressure_drop_Pa", "flow_m3_s"});
  require_units(log, std::numeric_limits<double>::min(),
                "a flow above 0 in m3/s, 1 at most: the flow drives the model, of a valve that stays open");
  Run run{.name = log.name,
          .whole = {.step_s = trace::period_s(log),
                    .pressure_Pa = log["pressure_drop_Pa"],
                    .flow_m3_s = log["flow_m3_s"]}};
  run.held_out_from = rows_before(run.whole.pressure_Pa.size(), held_out);
  if (run.held_out_from > 0 && run.held_out_from < 3)
    throw identify::CannotIdentify(fmt::format("{}: {} rows, expected 5 or more", log.name, log.rows));
  return run;
}

Transient fitted_part(const Run& run) {
  const auto rows = static_cast<std::ptrdiff_t>(run.held_out_from);
  return {.step_s = run.whole.step_s,
          .pressure_Pa = {run.whole.pressure_Pa.begin(), run.whole.pressure_Pa.begin() + rows},
          .flow_m3_s = {run.whole.flow_m3_s.begin(), run.whole.flow_m3_s.begin() + rows}};
}

void score(Run& run, const GreyBoxConfig& valve) {
  GreyBoxConfig at_once = valve;
  at_once.lag_s = 0.0;
  run.predicted_Pa = relief::predict_pressure(valve, run.whole);
  run.static_Pa = relief::predict_pressure(at_once, run.whole);
  const std::vector<double>& P = run.whole.pressure_Pa;
  const auto [least, most] = std::minmax_element(P.begin(), P.end());
  for (std::size_t k = run.held_out_from; k < P.size(); ++k) {
    const double error_Pa = std::abs(run.predicted_Pa[k] - P[k]);
    run.worst = std::max(run.worst, error_Pa / P[k]);
    run.static_worst = std::max(run.static_worst, std::abs(run.static_Pa[k] - P[k]) / P[k]);
    run.of_swing = std::max(run.of_swing, *most > *least ? error_Pa / (*most - *least) : 0.0);
  }
  run.final = relief::prediction_error(run.predicted_Pa, run.whole).final;
}

struct Answer {
  Curve curve;
  bool dynamic = false;
  GreyBoxConfig valve{};
  double lag_error_s = 0.0;
  std::vector<Run> runs{};  ///< those that are scored
};

Figures lag_of(const Answer& answer) {
  return {{"lag_s", "k2, lag", "ms", 1e3, answer.valve.lag_s, answer.lag_error_s}};
}

Answer identified(const Options& options) {
  Answer answer{.curve = fit_curve(options)};
  if (options.transients.empty()) return answer;
  std::vector<Run> fitted;
  std::vector<Transient> parts;
  for (const std::string& file : options.transients) {
    fitted.push_back(read_run(file, options.held_out.empty() ? kHeldOut : 0.0));
    parts.push_back(fitted_part(fitted.back()));
  }
  const StaticGreyBox& line = answer.curve.line;
  const GreyBoxConfig start{
      .k1_m2_Pa = line.k1_m2_Pa, .k3_m2 = line.k3_m2, .lag_s = 1.0, .density_kg_m3 = line.density_kg_m3};
  told_of(fitted.front().name, [&] {
    Progress progress("fitting the lag");
    answer.valve = relief::fit_lag(parts, start, kShortestLag_s, kLongestLag_s).valve;
    answer.lag_error_s = relief::lag_error_s(parts, answer.valve);
    if (!lag_of(answer).front().identified()) {
      throw identify::CannotIdentify(fmt::format(
          "the lag is {:.3g} ms +- {:.2g} ms: the transients do not show it, expected changes of flow that "
          "the valve follows late",
          1e3 * answer.valve.lag_s, 1e3 * answer.lag_error_s));
    }
  });
  answer.dynamic = true;
  if (options.held_out.empty()) {
    answer.runs = std::move(fitted);
  } else {
    for (const std::string& file : options.held_out) answer.runs.push_back(read_run(file, 1.0));
  }
  for (Run& run : answer.runs) score(run, answer.valve);
  return answer;
}

Figures figures_of(const StaticGreyBox& valve, const relief::StaticError& error, bool has_flow_force) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // a bound has no error
  const bool bound = valve.k3_m2 == 0.0;
  const std::string at_zero = bound ? "at its bound: no point is near where it cracks" : "";
  Figures figures{{"cracking_pressure_Pa", "cracking pressure", "bar", 1e-5, cracking_pressure_Pa(valve),
                   bound ? kNone : error.cracking_Pa, at_zero},
                  {"k1_m2_Pa", "k1", "mm2/bar", 1e11, valve.k1_m2_Pa, error.k1_m2_Pa},
                  {"k3_m2", "k3", "mm2", 1e6, valve.k3_m2, bound ? kNone : error.k3_m2, at_zero}};
  if (has_flow_force) {
    figures.push_back(
        {"k2_s_m_sqrtPa", "k2, flow force", "s/(m sqrt(Pa))", 1.0, valve.k2_s_m_sqrtPa, error.k2_s_m_sqrtPa});
    figures.push_back({"maximum_pressure_Pa", "maximum pressure", "bar", 1e-5, maximum_pressure_Pa(valve),
                       error.maximum_Pa});
  }
  return figures;
}

const char* kNoFlowForce = "no flow force: these points do not ask for one, and show no maximum pressure";

void print(const Options& options, const Answer& answer) {
  const Output& output = options.output;
  const Curve& curve = answer.curve;
  output.print("{}: {} points from {:.4g} to {:.4g} L/min, {} of a valve that is shut; density {:g} kg/m3\n",
               curve.name, curve.points.size(), kLitreMinute * curve.points.front().flow_m3_s,
               kLitreMinute * curve.points.back().flow_m3_s, curve.shut, options.density_kg_m3);
  print(output, figures_of(curve.bent, curve.bent_error, curve.has_flow_force), 2);
  if (!curve.has_flow_force) output.print("  {}\n", kNoFlowForce);
  output.print("  pressure errs by {:.3g} % at most; held out, each third point, by {:.3g} %\n",
               100.0 * curve.worst, 100.0 * curve.held_out_worst);
  if (!answer.dynamic) return;
  output.print("in motion, from the curve without flow force and {} transient{}\n", options.transients.size(),
               options.transients.size() == 1 ? "" : "s");
  print(output, figures_of(curve.line, curve.line_error, false), 2);
  print(output, lag_of(answer), 2);
  for (const Run& run : answer.runs) {
    output.print(
        "{}: held out from {:.3g} s, free run errs by {:.3g} % at most ({:.3g} % of the swing), at the end "
        "by "
        "{:.3g} %; without lag by {:.3g} %\n",
        run.name, run.held_out_s(), 100.0 * run.worst, 100.0 * run.of_swing, 100.0 * run.final,
        100.0 * run.static_worst);
  }
}

Json json_of(const Options& options, const Answer& answer) {
  const Curve& curve = answer.curve;
  Json json{{"schema", "plenum-relief/1"},
            {"density_kg_m3", options.density_kg_m3},
            {"static",
             {{"file", curve.name},
              {"points", curve.points.size()},
              {"shut", curve.shut},
              {"flow_force", curve.has_flow_force},
              {"parameters", to_json(figures_of(curve.bent, curve.bent_error, curve.has_flow_force))},
              {"worst_error", number(curve.worst)},
              {"held_out_worst_error", number(curve.held_out_worst)}}}};
  if (!answer.dynamic) return json;
  Figures figures = figures_of(curve.line, curve.line_error, false);
  figures.push_back(lag_of(answer).front());
  json["dynamic"] = {{"parameters", to_json(figures)}, {"runs", Json::array()}};
  for (const Run& run : answer.runs) {
    json["dynamic"]["runs"].push_back({{"file", run.name},
                                       {"held_out_from_s", run.held_out_s()},
                                       {"worst_error", number(run.worst)},
                                       {"worst_error_of_swing", number(run.of_swing)},
                                       {"final_error", number(run.final)},
                                       {"worst_error_without_lag", number(run.static_worst)}});
  }
  return json;
}

report::Curve drawn(const char* name, const StaticGreyBox& valve, double most_m3_s) {
  report::Curve curve{.name = name, .x = {}, .y = {}};
  for (std::size_t i = 1; i <= kDrawn; ++i) {
    const double Q = most_m3_s * static_cast<double>(i) / static_cast<double>(kDrawn);
    curve.x.push_back(kLitreMinute * Q);
    curve.y.push_back(1e-5 * plant::relief_valve::pressure_Pa(valve, Q));
  }
  return curve;
}

std::vector<double> bar(std::vector<double> pressure_Pa) {
  for (double& P : pressure_Pa) P *= 1e-5;
  return pressure_Pa;
}

report::Page page_of(const Answer& answer) {
  const Curve& curve = answer.curve;
  report::Page page("Relief valve, from its curve and its transients");
  page.lead(
      "The grey box knows a relief valve by its ports: the opening follows the pressure along a straight "
      "line, with what the flow force adds, and lags behind it in motion. First the curve at rest, then the "
      "lag "
      "alone.");
  std::vector<report::Tile> tiles{{"Cracking pressure", 1e-5 * cracking_pressure_Pa(curve.bent), "bar"},
                                  {"Held-out points", 100.0 * curve.held_out_worst, "% of pressure"}};
  if (answer.dynamic) {
    tiles.push_back({"Lag", 1e3 * answer.valve.lag_s, "ms"});
    tiles.push_back({"Held out in free run",
                     100.0 * answer.runs.front().worst,
                     "% of pressure",
                     {},
                     answer.runs.front().name});
  }
  page.tiles(std::move(tiles));
  report::Curve points{
      .name = "measured", .x = {}, .y = {}, .stroke = report::Stroke::kPoints, .ink = report::Ink::kNeutral};
  report::Curve errors{.name = "model - measured", .x = {}, .y = {}, .stroke = report::Stroke::kPoints};
  for (const auto& [P, Q] : curve.points) {
    points.x.push_back(kLitreMinute * Q);
    points.y.push_back(1e-5 * P);
    errors.x.push_back(kLitreMinute * Q);
    errors.y.push_back(100.0 * (plant::relief_valve::pressure_Pa(curve.bent, Q) / P - 1.0));
  }
  const double most_m3_s = curve.points.back().flow_m3_s;
  report::XyChart at_rest{.title = "Pressure over flow, at rest",
                          .x = {"Flow", "L/min"},
                          .y = {"Pressure", "bar"},
                          .curves = {std::move(points), drawn("without flow force", curve.line, most_m3_s)}};
  if (curve.has_flow_force) at_rest.curves.push_back(drawn("with flow force", curve.bent, most_m3_s));
  report::Section& rest = page.section(fmt::format("{}: at rest", curve.name));
  rest.row({std::move(at_rest),
            report::XyChart{.title = "Error of pressure",
                            .caption = fmt::format("{:.3g} % at most.", 100.0 * curve.worst),
                            .x = {"Flow", "L/min"},
                            .y = {"Error", "%"},
                            .curves = {std::move(errors)}}})
      .table(table_of(figures_of(curve.bent, curve.bent_error, curve.has_flow_force), "At rest"));
  if (!curve.has_flow_force) rest.note(std::string("There is ") + kNoFlowForce + ".");
  if (!answer.dynamic) return page;
  Figures figures = figures_of(curve.line, curve.line_error, false);
  figures.push_back(lag_of(answer).front());
  page.section("In motion").table(table_of(figures, "The curve without flow force, and the lag"));
  for (const Run& run : answer.runs) {
    std::vector<double> flow = run.whole.flow_m3_s;
    for (double& Q : flow) Q *= kLitreMinute;
    report::LineChart pressure{
        .title = "Pressure",
        .caption = fmt::format("Held out: {:.3g} % at most, at the end {:.3g} %.", 100.0 * run.worst,
                               100.0 * run.final),
        .y = {"Pressure", "bar"},
        .curves = {{"measured", run.time_s(), bar(run.whole.pressure_Pa), report::Stroke::kSolid,
                    report::Ink::kNeutral},
                   {"free run", run.time_s(), bar(run.predicted_Pa)},
                   {"without lag", run.time_s(), bar(run.static_Pa), report::Stroke::kDashed}},
        .group = run.name};
    if (run.held_out_from > 0) pressure.marks.push_back(held_out_from(run.held_out_s()));
    page.section(run.name).row(
        {std::move(pressure), report::LineChart{.title = "Flow",
                                                .y = {"Flow", "L/min"},
                                                .curves = {{"flow", run.time_s(), std::move(flow)}},
                                                .group = run.name}});
  }
  return page;
}

int run(const Options& options) {
  if (!options.held_out.empty() && options.transients.empty())
    throw std::invalid_argument("--heldout without --transient, expected one to fit the lag to");
  const Answer answer = identified(options);
  print(options, answer);
  write_report(options.output, options.report, [&] { return page_of(answer); });
  options.output.finish(json_of(options, answer));
  return kDone;
}

}  // namespace

Command add_relief(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("relief", "Fit a relief valve to its pressure-flow curve, and its lag to transients");
  arguments
      .option("CURVE", options->curve,
              "Points at rest: the columns pressure_drop_Pa (above the tank's) and flow_m3_s. Those of less "
              "than a "
              "hundredth of the greatest flow are of a valve that is shut, and left out")
      .type_name("CURVE.csv")
      .required();
  arguments
      .option("--transient", options->transients,
              "Recordings with the columns time_s, pressure_drop_Pa and flow_m3_s, from rest: the lag is "
              "fitted to "
              "these (default: none)")
      .type_name("RUN.csv");
  arguments
      .option("--heldout", options->held_out,
              "Transients to score the free run on (default: the last 40 % of each --transient is held out)")
      .type_name("RUN.csv");
  arguments.option("--density", options->density_kg_m3, "Of the fluid [kg/m3]")
      .within(0.1, 2e4)
      .show_default();
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum relief curve.csv --transient step.csv --heldout other-step.csv --report relief.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
