#include "host-sim/tools/identify_greybox.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "host-sim/identify/chamber/fit_greybox.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/fit_origin.hpp"
#include "host-sim/tools/gap_text.hpp"
#include "host-sim/tools/model_charts.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"
#include "host-sim/tools/useful.hpp"

namespace plenum::host::tools {
namespace {

using identify::chamber::FigureFit;
using identify::chamber::GreyboxFit;
using identify::chamber::NotTold;
using identify::chamber::TriedEffects;
using trace::NamedLog;

/// Of an effect without which the fit is as good.
constexpr const char* kNotNeeded = "tried, not needed";

std::string error_of(const FigureFit& figure) {
  return std::isfinite(figure.standard_error) ? fmt::format("{:.2g}", figure.standard_error) : std::string();
}

std::string text_of(const TriedEffects& tried) {
  return tried.effects.empty() ? "no effect" : listed(tried.effects, "and");
}

std::string kept_text(const GreyboxFit& fit) {
  return fit.kept.empty() ? "no effect" : listed(fit.kept, "and");
}

/// A log against the model's free run over the whole of it.
struct Prediction {
  identify::chamber::WholeRun run;
  double rms_kPa = 0.0;   ///< of the rows that have settled
  double held_kPa = 0.0;  ///< of holding the log's mean
};
Prediction predict(const GreyboxFit& fit, const trace::Log& log) {
  Prediction made{identify::chamber::free_run_over(fit.rig, log), 0.0, identify::held_mean_rms_kPa(log)};
  double square = 0.0;
  const std::size_t settled = made.run.settled_rows;
  for (std::size_t row = settled; row < log.size(); ++row) {
    const double error_kPa = 1e-3 * (made.run.pressure_Pa[row] - log.pressure_Pa[row]);
    square += error_kPa * error_kPa;
  }
  made.rms_kPa = std::sqrt(square / static_cast<double>(log.size() - settled));
  return made;
}

void print_fit(const Output& output, const GreyboxFit& fit) {
  for (const FigureFit& figure : fit.parameters) {
    const std::string error = error_of(figure);
    output.print("{:<28} {:>12.6g}  {:<12} {}\n", figure.name, figure.value,
                 error.empty() ? "" : "+- " + error, mark_of(figure.at_bound, figure.identifiable));
  }
  for (const NotTold& figure : fit.not_told) {
    output.print("{:<28} {:>12.6g}  {:<12} {}\n", figure.name, figure.value, "", kNotNeeded);
  }
  for (const TriedEffects& tried : fit.tried) {
    output.print("tried with {:<35} held-out rows {:.3f} kPa\n", text_of(tried), tried.heldout_kPa);
  }
  output.print("kept: {}\n", kept_text(fit));
  output.print("RMS next tick {:.3f} kPa, free run over whole logs {:.3f} kPa, noise {:.3f} kPa; {} rows\n",
               fit.rms_next_tick_kPa, fit.rms_free_run_kPa, fit.noise_kPa, fit.rows);
  output.print("stopped after {} iterations: {}\n", fit.iterations, fit.stop);
  constexpr double kUnexplained = 5.0;  // times the noise
  if (fit.rms_free_run_kPa > kUnexplained * fit.noise_kPa) {
    output.print(
        "the free run errs by {:.0f} times the noise: plenum diagnose tells which effect is missing\n",
        fit.rms_free_run_kPa / fit.noise_kPa);
  }
}

void add_log(report::Section& section, const GreyboxFit& fit, const NamedLog& of) {
  const Prediction made = predict(fit, of.log);
  report::Curve error{"predicted - measured", {}, {}};
  for (std::size_t row = made.run.settled_rows; row < of.log.size(); ++row) {
    error.x.push_back(of.log.time_s[row]);
    error.y.push_back(1e-3 * (made.run.pressure_Pa[row] - of.log.pressure_Pa[row]));
  }
  const report::Curve measured{"measured", of.log.time_s, scaled(of.log.pressure_Pa, 1e-3),
                               report::Stroke::kSolid, report::Ink::kNeutral};
  section.row(
      {report::LineChart{
           .title = of.name,
           .caption = fmt::format("RMS error {:.3g} kPa from {:.2g} s on; holding the log's mean {:.3g} kPa.",
                                  made.rms_kPa, error.x.front(), made.held_kPa),
           .y = {"Pressure", "kPa"},
           .curves = {measured,
                      {"predicted, one free run", of.log.time_s, scaled(made.run.pressure_Pa, 1e-3)}},
           .group = of.name},
       report::LineChart{
           .title = fmt::format("Error, {}", of.name),
           .caption = fmt::format("Predicted minus measured. The rows before {:.2g} s count in no "
                                  "error: they show what was before the log.",
                                  error.x.front()),
           .x = {.quantity = "Time", .unit = "s", .min = of.log.time_s.front()},
           .y = {"Error", "kPa"},
           .curves = {std::move(error)},
           .group = of.name}});
}

report::Page page_of(const GreyboxRequest& request, const GreyboxFit& fit) {
  std::vector<std::string> names;
  for (const NamedLog& of : request.fitted) names.push_back(of.name);
  report::Page page(fmt::format("The grey-box model of {}", listed(names, "and")));
  page.lead(fmt::format("The chamber's physics with {}, fitted in free run.{}", kept_text(fit),
                        fit.converged ? "" : fmt::format(" It did not converge: {}.", fit.stop)));
  page.tiles({{"Next tick, RMS", to_three_digits(fit.rms_next_tick_kPa), "kPa", {}, "on the fitted logs"},
              {"Free run, RMS", to_three_digits(fit.rms_free_run_kPa), "kPa", {}, "over whole logs"},
              {"Held out, RMS", to_three_digits(fit.rms_heldout_kPa), "kPa", {}, "the last 40 % of each log"},
              {"Noise", to_three_digits(fit.noise_kPa), "kPa", {}, "white part of the error"},
              {"Samples", static_cast<double>(fit.rows), "", {}, "rows of the fitted logs that count"}});
  if (!request.predicted.empty()) {
    report::Section& section = page.section("Logs that the fit has not seen");
    for (const NamedLog& of : request.predicted) add_log(section, fit, of);
  }
  report::Section& fitted = page.section("Fitted logs");
  for (const NamedLog& of : request.fitted) add_log(fitted, fit, of);

  report::Table figures{.caption = "Figures and their standard errors",
                        .columns = {"Figure", "Value", "Standard error", ""},
                        .rows = {}};
  for (const FigureFit& figure : fit.parameters) {
    figures.rows.push_back({figure.name, fmt::format("{:.6g}", figure.value),
                            error_of(figure).empty() ? "-" : error_of(figure),
                            mark_of(figure.at_bound, figure.identifiable)});
  }
  for (const NotTold& figure : fit.not_told) {
    figures.rows.push_back(
        {figure.name, fmt::format("{:.6g}", figure.value), std::string("-"), std::string(kNotNeeded)});
  }
  report::Table effects{
      .caption = "Effects that were tried", .columns = {"With", "Held-out rows, RMS [kPa]"}, .rows = {}};
  for (const TriedEffects& tried : fit.tried) {
    effects.rows.push_back({text_of(tried), report::Fixed{tried.heldout_kPa, 3}});
  }
  page.section("The model")
      .table(figures)
      .table(effects)
      .note(
          "An effect is kept when without it the squares of the rows that it was not fitted to are 10 % "
          "larger, "
          "and, where it has a single figure, when that is three standard errors from where it vanishes or "
          "the squares of all rows are 10 % larger without it. "
          "Standard errors are for errors as correlated as these are.");
  return page;
}

}  // namespace

int identify_greybox(const GreyboxRequest& request, const Output& output) {
  std::vector<trace::Log> logs;
  for (const NamedLog& of : request.fitted) logs.push_back(of.log);
  const auto fit_to = [&](const std::vector<trace::Log>& to) {
    Progress progress("identifying");
    return identify::chamber::fit_greybox(to, request.rig, std::ref(progress));
  };
  const auto free_runs_kPa = [](const GreyboxFit& of, const std::vector<trace::Log>& over) {
    return pooled_rms_kPa(over, [&](const trace::Log& log) { return predict(of, log).rms_kPa; });
  };
  const GreyboxFit fit = fit_to(logs);
  require_useful(
      {.model_kPa = free_runs_kPa(fit, logs),
       .held_kPa = pooled_rms_kPa(logs, identify::held_mean_rms_kPa),
       .held = "means"},
      [&](const std::vector<trace::Log>& turned) { return free_runs_kPa(fit_to(turned), turned); }, logs);
  trace::ModelFile model = identify::chamber::to_model_file(fit, request.chamber);
  state_origin(model, request.date_s, request.rig);
  trace::write_model(request.out, model);
  print_fit(output, fit);

  Json predicted = Json::array();
  for (const NamedLog& of : request.predicted) {
    const Prediction made = predict(fit, of.log);
    output.print("predicts {}: RMS {:.3f} kPa in one free run; {:.3f} kPa by holding the log's mean\n",
                 of.name, made.rms_kPa, made.held_kPa);
    predicted.push_back({{"file", of.name},
                         {"rms_free_run_kPa", number(made.rms_kPa)},
                         {"rms_mean_held_kPa", number(made.held_kPa)}});
  }
  const std::vector<std::string> left_out = model.fit.value("left_out", std::vector<std::string>{});
  output.print("model: {}{}\n", request.out,
               left_out.empty() ? "" : fmt::format(", without {} of the rig", fmt::join(left_out, ", ")));
  write_report(output, request.report, [&] { return page_of(request, fit); });
  Json result = Json::parse(trace::format_model(model));
  result["file"] = request.out;
  result["predicted"] = predicted;
  output.finish(result);
  require_converged(fit.converged, fit.stop, request.out);
  return kDone;
}

}  // namespace plenum::host::tools
