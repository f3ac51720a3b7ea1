#include "host-sim/diagnose/diagnose.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "host-sim/diagnose/found_rig.hpp"
#include "host-sim/diagnose/gap_json.hpp"
#include "host-sim/diagnose/log_check.hpp"
#include "host-sim/identify/chamber/fit.hpp"
#include "host-sim/identify/chamber/next_tick.hpp"
#include "host-sim/identify/greybox.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/diagnose_report.hpp"
#include "host-sim/tools/effects.hpp"
#include "host-sim/tools/fit_origin.hpp"
#include "host-sim/tools/gap_text.hpp"
#include "host-sim/tools/log_input.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"

namespace plenum::host::tools {
namespace {

using diagnose::GapReport;
using diagnose::NamedEffect;

struct Options {
  LogInput input;
  std::vector<std::string> logs;
  std::vector<std::string> heldout;
  std::vector<std::string> baseline;
  std::vector<std::string> strike;
  std::string report;
  std::string save_rig;
  std::string save_model;
  std::string date;
  Output output;
};

/// The error from zero to as configured, in characters: what is noise, what is left, what effects and what
/// calibration close.
std::string gap_bar(const GapReport& report) {
  constexpr double kCharacters = 60.0;
  const std::array<std::pair<double, char>, 4> parts{{{report.noise_floor_Pa, '#'},
                                                      {report.with_effects_Pa, '='},
                                                      {report.recalibrated_Pa, '+'},
                                                      {report.as_configured_Pa, '.'}}};
  double full_Pa = 0.0;
  for (const auto& [to_Pa, mark] : parts) full_Pa = std::max(full_Pa, to_Pa);
  std::string bar;
  for (const auto& [to_Pa, mark] : parts) {
    const auto to = full_Pa > 0.0 ? static_cast<std::size_t>(std::lround(kCharacters * to_Pa / full_Pa)) : 0;
    if (to > bar.size()) bar.append(to - bar.size(), mark);
  }
  return bar;
}

void print_report(const Output& output, const GapReport& report) {
  constexpr std::size_t kRegimes = 3;
  if (report.baseline) output.print("before    {}\n", baseline_sentence(report));
  output.print("gap       [{}]\n", gap_bar(report));
  const char* floor = report.baseline ? "floor" : "noise";
  output.print("          as configured {}, recalibrated {} ({}), with effects {}, {} {}\n",
               kPa_text(report.as_configured_Pa), kPa_text(report.recalibrated_Pa), p_text(report),
               kPa_text(report.with_effects_Pa), floor, kPa_text(report.noise_floor_Pa));
  output.print("          (. closed by calibration, + by effects; = left, # {})\n", floor);
  output.print("verdict   {}: {}\n", name_of(report.verdict), verdict_sentence(report));
  const char* title = "effects";
  for (const NamedEffect& one : report.effects) {
    output.print("{:<9} {} {}: {}{}\n", title, one.id, percent(one.confidence), parameters_text(one),
                 one.aliases.empty() ? "" : "; not told from " + listed(one.aliases, "and"));
    title = "";
  }
  if (report.equation) {
    output.print("equation  {} {}\n", report.equation->equation, percent(report.equation->confidence));
  }
  std::string where;
  for (std::size_t i = 0; i < std::min(kRegimes, report.where.size()); ++i) {
    where += fmt::format("{}{} {}", where.empty() ? "" : "; ", percent(report.where[i].share),
                         report.where[i].regime);
  }
  if (!where.empty()) output.print("where     {}\n", where);
  std::string alike;
  for (const auto& of : report.alias_classes) alike += (alike.empty() ? "" : "; ") + listed(of, "and");
  if (!alike.empty())
    output.print("alike     {}: while small these look the same under this excitation\n", alike);
  if (report.next) output.print("next      {}\n", next_text(report));
  if (const std::string stamps = stamps_sentence(report); !stamps.empty())
    output.print("stamps    {}\n", stamps);
}

/// A sensor's error is no model's: with it in the calibration, bus, log and limits show true pressures.
void print_calibration(const Options& options, const trace::RigDescription& found) {
  const auto bias = found.effects.find("sensor_bias");
  if (bias == found.effects.end()) return;
  const auto figure = [&](const char* name) {
    const auto at = bias->second.find(name);
    return at != bias->second.end() ? at->second : 0.0;
  };
  const auto chamber = chamber_in_name(options.logs.front());
  options.output.print(
      "calibration: plenum calibrate --chamber {} --offset {:.5g} --gain-error {:.5g} --ambient {:g}\n",
      chamber ? std::to_string(*chamber) : "N", figure("offset_kPa"), figure("gain_error"),
      found.ambient.pressure_Pa / 1e3);
  if (const double drift_kPa = figure("drift_at_60_s_kPa"); drift_kPa != 0.0) {
    options.output.print("  leaves its drift: {:.3g} kPa within a minute of the log's start\n", drift_kPa);
  }
  for (const auto& [name, of] :
       {std::pair{"ground_kPa_V", ""}, {"ground_even_kPa_V", " off the null, either way"}}) {
    if (const double ground_kPa_V = figure(name); ground_kPa_V != 0.0)
      options.output.print(
          "  leaves what a ground that is shared with the valve adds: {:.3g} kPa for each volt of the "
          "command{}\n",
          ground_kPa_V, of);
  }
  if (const double bend = figure("non_linearity"); bend != 0.0) {
    options.output.print("  leaves its bend: {:.3g} kPa half way from ambient to supply\n",
                         1e-3 * bend * (found.supply.pressure_Pa - found.ambient.pressure_Pa));
  }
}

void save_model(const Options& options, std::uint32_t date_s, const trace::RigDescription& found,
                const std::vector<trace::NamedLog>& logs) {
  // a null that wanders does so another way in each log, and that which is found is the first one's
  const auto drift = found.effects.find("null_drift");
  const bool wanders = drift != found.effects.end() && drift->second.contains("wander_1_V");
  const std::vector<double>& time_s = (wanders ? logs.front() : logs.back()).log.time_s;
  identify::GreyboxModel model =
      identify::greybox_of(found, chamber_in_name(options.logs.front()), time_s.back() - time_s.front());
  identify::chamber::Scene scene = identify::chamber::make_scene(model.rig);
  for (const trace::NamedLog& log : logs)
    identify::chamber::add_record(scene, identify::chamber::make_record(log.name, log.log, 1.0));
  model.file.fit["rms_one_step_kPa"] = 1e-3 * identify::chamber::next_tick_rms_Pa(scene, 0, scene.nominal);
  state_origin(model.file, date_s, found);
  trace::write_model(options.save_model, model.file);
  const std::vector<std::string> without = model.without();
  options.output.print("model: {}{}\n", options.save_model,
                       without.empty() ? "" : ", without " + listed(without, "and"));
  if (drift != found.effects.end()) {
    options.output.print("its null is where it stood at the end of the {}\n",
                         logs.size() == 1 ? "log"
                         : wanders        ? "first log: each log has a way of its own"
                                          : "last log");
  }
  print_calibration(options, found);
}

int run(const Options& options) {
  if (!options.input.has_rig() && !options.input.of_ventilator()) {
    throw std::invalid_argument("--rig is missing, expected the RIG.toml that the logs are of");
  }
  for (const std::string& id : options.strike) effect_of(id, "--strike");
  const std::uint32_t date_s = fit_date_s(options.date);
  const trace::RigDescription rig = options.input.rig();
  const auto logs = options.input.read(options.logs, rig);
  const auto heldout = options.input.read(options.heldout, rig);
  const auto baseline = options.input.read(options.baseline, rig);
  diagnose::require_diagnosable(logs, rig);
  for (const auto* others : {&baseline, &heldout}) {
    if (!others->empty()) diagnose::require_diagnosable(*others, rig);
  }
  options.input.print_assumed(options.output);
  if (heldout.empty()) options.input.tell(diagnose::notices_of_rests(logs, diagnose::kFittedShare));

  GapReport report;
  {
    Progress progress("diagnosing");
    diagnose::DiagnoseOptions how;
    how.progress = std::ref(progress);
    how.strike = options.strike;
    how.baseline = baseline;
    report = diagnose::diagnose(logs, heldout, rig, how);
  }
  print_report(options.output, report);
  options.output.finish(diagnose::to_json(report));  // first: what follows may be refused
  if (!options.save_rig.empty()) {
    trace::write_rig(options.save_rig, report.found);
    options.output.print("rig: {}\n", options.save_rig);
  }
  if (!options.save_model.empty()) save_model(options, date_s, report.found, logs);
  write_report(options.output, options.report, [&] { return diagnose_page(report); });
  return kDone;
}

}  // namespace

Command add_diagnose(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command("diagnose",
                                        "Say where simulation and measurement diverge, which effect is "
                                        "missing, and how much of the gap it closes");
  arguments.option("LOG", options->logs, "Logs of one chamber").type_name("LOG.csv").required();
  options->input.add_to(
      arguments, "What is known of the rig: where calibration starts (needed, except for ventilator runs)");
  arguments
      .option("--heldout", options->heldout,
              "A log on which errors are reported; repeatable (default: the last 40 % of each LOG)")
      .type_name("HELD.csv")
      .one_at_a_time();
  arguments
      .option("--baseline", options->baseline,
              "A log of the same chamber from before, repeatable: find what has changed since, by effects or "
              "by the valve")
      .type_name("OLD.csv")
      .one_at_a_time();
  arguments.option("--strike", options->strike, "Leave this effect out of the catalogue; repeatable")
      .type_name("ID")
      .one_at_a_time();
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  arguments
      .option("--save-rig", options->save_rig,
              "Write the rig with its valve as fitted and the effects found (default: do not)")
      .type_name("OUT.toml");
  arguments
      .option("--save-model", options->save_model,
              "Write the board's grey-box model with the valve as fitted and the effects found that it has "
              "parameters for, and say what becomes of a sensor_bias (default: do not)")
      .type_name("MODEL.json");
  add_fit_date(arguments, options->date);
  options->output.add_to(arguments);
  arguments.footer(
      example("  plenum diagnose --rig logs/rig.toml logs/chamber-1.csv --json gap.json --report gap.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
