#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

#include "host-sim/diagnose/log_check.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/identify/profile.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/fit_origin.hpp"
#include "host-sim/tools/identify_greybox.hpp"
#include "host-sim/tools/identify_report.hpp"
#include "host-sim/tools/log_input.hpp"
#include "host-sim/tools/model_charts.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"
#include "host-sim/tools/useful.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/model_json.hpp"

namespace plenum::host::tools {
namespace {

using identify::ParameterFit;

constexpr std::string_view kGreybox = "greybox";
constexpr std::array<std::string_view, 3> kModels{"tassa9", "tassa9r", kGreybox};
constexpr std::string_view kAuto = "auto";

struct Options {
  std::string model{kModels.front()};
  /// That only the 9-parameter forms have: given or not.
  std::vector<Option> of_tassa9;
  LogInput input;
  std::vector<std::string> logs;
  std::vector<std::string> predict;
  std::string c_gamma{kAuto};
  std::string dead_time{kAuto};
  double stretch_s = 0.2;
  bool free_run = true;
  unsigned chamber = 0;
  std::string date;
  std::string out = "model.json";
  std::string report;
  Output output;
};

/// Of an option that takes a number or auto; none of all the text.
std::optional<double> number_in(const std::string& text) {
  try {
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    if (used == text.size()) return value;
  } catch (const std::exception&) {
    // it is no number
  }
  return std::nullopt;
}

double kink_width_V(const std::string& text) {
  const auto value = number_in(text);
  if (!value || !(*value > 0.0 && *value <= 10.0)) {
    throw std::invalid_argument(
        fmt::format("--c-gamma {}: expected auto, or a width above 0 and up to 10 V", text));
  }
  return *value;
}

double dead_time_s(const std::string& text) {
  const auto value = number_in(text);
  if (!value || !(*value >= 0.0 && *value <= trace::kLongestDeadTime_s)) {
    throw std::invalid_argument(
        fmt::format("--dead-time {}: expected auto, or 0 to {} s", text, trace::kLongestDeadTime_s));
  }
  return *value;
}

void print_fit(const Output& output, const identify::Tassa9Fit& fit, double stretch_s) {
  const auto print = [&](std::string_view name, const ParameterFit& parameter) {
    const std::string error =
        std::isfinite(parameter.standard_error) ? fmt::format("+- {:.2g}", parameter.standard_error) : "";
    output.print("{:<16} {:>12.6g}  {:<12} {}\n", name, parameter.value, error, mark_of(parameter));
  };
  for (std::size_t i = 0; i < identify::kFree; ++i) {
    if (identify::has_parameter(fit.model.form, i)) print(trace::kTassa9Names[i], fit.parameters[i]);
  }
  output.print("{:<16} {:>12.6g}  {:<12} held\n", "c_gamma_V", fit.model.c_gamma_V, "");
  print(trace::kTassa9Names.back(), fit.dead_time);
  const auto at_bound = [](const ParameterFit& one) { return one.at_bound != identify::Bound::none; };
  if (std::ranges::any_of(fit.parameters, at_bound) || at_bound(fit.dead_time)) {
    output.print(
        "at its bound: the logs would have it beyond what the model admits; the errors below are with it "
        "there\n");
  }
  output.print("condition {:.3g}; RMS one step {:.3f} kPa, free run over {:g} s {:.3f} kPa; {} rows\n",
               fit.condition, fit.rms_one_step_kPa, stretch_s, fit.rms_free_run_kPa, fit.rows);
  output.print("stopped after {} iterations: {}\n", fit.iterations, fit.stop);
}

double free_runs_kPa(const identify::Tassa9Fit& fit, const std::vector<trace::Log>& logs) {
  return pooled_rms_kPa(
      logs, [&](const trace::Log& log) { return identify::free_run_rms_kPa(fit.model, log, kFreeRun_s); });
}

FitError error_of(const identify::Tassa9Fit& fit, const std::vector<trace::Log>& logs) {
  const double start_kPa = pooled_rms_kPa(
      logs, [](const trace::Log& log) { return identify::held_start_rms_kPa(log, kFreeRun_s); });
  const double mean_kPa = pooled_rms_kPa(logs, identify::held_mean_rms_kPa);
  return {.model_kPa = free_runs_kPa(fit, logs),
          .held_kPa = std::min(start_kPa, mean_kPa),
          .held = start_kPa < mean_kPa ? "start pressures" : "means"};
}

int run_greybox(const Options& options) {
  for (const Option& option : options.of_tassa9) {
    if (option.given()) {
      throw std::invalid_argument(
          fmt::format("{}: the grey-box model has none, expected with --model tassa9", option.name()));
    }
  }
  const trace::RigDescription rig = options.input.rig();
  const auto fitted = options.input.read(options.logs, rig);
  diagnose::require_length(fitted);
  const auto predicted = options.input.read(options.predict, rig);
  options.input.print_assumed(options.output);
  return identify_greybox({.rig = rig,
                           .fitted = fitted,
                           .predicted = predicted,
                           .chamber = options.chamber != 0 ? std::optional(options.chamber)
                                                           : chamber_in_name(options.logs.front()),
                           .date_s = fit_date_s(options.date),
                           .out = options.out,
                           .report = options.report},
                          options.output);
}

int run(const Options& options) {
  if (options.model == kGreybox) return run_greybox(options);
  identify::FitOptions how;
  how.stretch_s = options.stretch_s;
  how.refine_free_run = options.free_run;
  how.form = identify::form_of(options.model);
  const identify::Profiled profiled{.kink_width = options.c_gamma == kAuto,
                                    .dead_time = options.dead_time == kAuto};
  if (!profiled.kink_width) how.c_gamma_V = kink_width_V(options.c_gamma);
  if (!profiled.dead_time) how.dead_time_s = dead_time_s(options.dead_time);
  const std::uint32_t date_s = fit_date_s(options.date);
  const trace::RigDescription rig = options.input.rig();
  Identified identified{.fit = {},
                        .stretch_s = options.free_run ? options.stretch_s : 0.0,
                        .fitted = options.input.read(options.logs, rig),
                        .predicted = options.input.read(options.predict, rig),
                        .ventilator = options.input.of_ventilator()};
  diagnose::require_length(identified.fitted);
  options.input.print_assumed(options.output);
  std::vector<trace::Log> logs;
  for (const NamedLog& of : identified.fitted) logs.push_back(of.log);

  const auto fit_to = [&](const std::vector<trace::Log>& to) {
    return identify::fit_tassa9_profiled(to, rig, how, profiled);
  };
  identified.fit = fit_to(logs);
  const identify::Tassa9Fit& fit = identified.fit;
  require_useful(
      error_of(fit, logs),
      [&](const std::vector<trace::Log>& turned) { return free_runs_kPa(fit_to(turned), turned); }, logs);

  const std::optional<unsigned> chamber =
      options.chamber != 0 ? std::optional(options.chamber) : chamber_in_name(options.logs.front());
  trace::ModelFile model = identify::to_model_file(fit, chamber);
  state_origin(model, date_s, rig);
  trace::write_model(options.out, model);
  print_fit(options.output, fit, options.stretch_s);

  Json predicted = Json::array();
  for (std::size_t i = 0; i < options.predict.size(); ++i) {
    const trace::Log& log = identified.predicted[i].log;
    const double rms_kPa = identify::free_run_rms_kPa(fit.model, log, kFreeRun_s);
    const double held_kPa = identify::held_start_rms_kPa(log, kFreeRun_s);
    options.output.print(
        "predicts {}: RMS {:.3f} kPa in free runs of 2 s; {:.3f} kPa by holding their start pressure\n",
        options.predict[i], rms_kPa, held_kPa);
    predicted.push_back({{"file", options.predict[i]},
                         {"rms_free_run_2_s_kPa", number(rms_kPa)},
                         {"rms_start_held_2_s_kPa", number(held_kPa)}});
  }
  options.output.print("model: {}\n", options.out);
  write_report(options.output, options.report, [&] { return identify_page(identified); });
  Json result = Json::parse(trace::format_model(model));
  result["file"] = options.out;
  result["predicted"] = predicted;
  options.output.finish(result);
  require_converged(fit.converged, fit.stop, options.out);
  return kDone;
}

}  // namespace

Command add_identify(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command("identify", "Fit a model of a chamber to its logs");
  arguments.option("LOG", options->logs, "Logs of one chamber").type_name("LOG.csv").required();
  options->input.add_to(arguments,
                        "What is known of the rig; its supply and ambient pressure are used (default: 700 "
                        "and 101.325 kPa), and the "
                        "serial numbers of the chamber's valve and sensor go into the model");
  arguments
      .option("--model", options->model,
              "tassa9 as published; tassa9r: with the moving volume where the physics has it (for chambers "
              "that move fast); greybox: the chamber's physics, with the effects that the logs demand")
      .one_of(std::vector<std::string>(kModels.begin(), kModels.end()))
      .show_default();
  const Option c_gamma =
      arguments
          .option(
              "--c-gamma", options->c_gamma,
              "Width of the kink at the valve's null [V]; auto tries 0.1 (the paper's), 0.2, 0.4, 0.8, 1.6")
          .type_name("V|auto")
          .show_default();
  const Option dead_time = arguments
                               .option("--dead-time", options->dead_time,
                                       "From a command to the valve's answer [s], which the model states to "
                                       "the board; auto tries 0 to 0.12, and takes the shorter of what "
                                       "the logs do not tell apart")
                               .type_name("S|auto")
                               .show_default();
  const Option stretch =
      arguments
          .option("--stretch", options->stretch_s, "Free runs that the fit is refined on are this long [s]")
          .within(0.02, 60.0)
          .show_default();
  const Option no_free_run = arguments.flag("!--no-free-run", options->free_run,
                                            "Stop after the fit of the next tick (default: refine)");
  options->of_tassa9 = {c_gamma, dead_time, stretch, no_free_run};
  arguments
      .option("--predict", options->predict,
              "Predict these logs in free runs of 2 s (greybox: in one), and tell the error")
      .type_name("LOG.csv");
  arguments
      .option("--chamber", options->chamber, "Chamber of the board, from 1 (default: N of chamber-N.csv)")
      .within(1, 8);
  add_fit_date(arguments, options->date);
  arguments.option("-o,--out", options->out, "Model file to write").type_name("FILE").show_default();
  arguments
      .option("--report", options->report,
              "Page to write: predictions against the logs, parameters, curves (default: none)")
      .type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum identify --rig first/rig.toml first/chamber-1.csv -o model-1.json --report fit-1.html\n"
      "  plenum identify --model greybox --rig first/rig.toml first/chamber-1.csv -o model-1.json"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
