#include "host-sim/tools/identify_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host-sim/identify/free_run.hpp"
#include "host-sim/tools/model_charts.hpp"
#include "host-sim/trace/model_json.hpp"

namespace plenum::host::tools {
namespace {

/// Volumes closer than this share their curve.
constexpr double kSameVolume = 0.01;

/// What each parameter of the model is, c1 to c9 and c_gamma, in words.
constexpr std::array<const char*, identify::kFree + 1> kMeanings{
    "command at the middle of s, about the valve's null",
    "how steeply s rises there",
    "how much more steeply away from there",
    "how far s moves with the volume's rate",
    "what the volume's rate adds to r",
    "how much volume slows r",
    "how fast r grows with the command",
    "how much faster r grows on the supply's side than on the exhaust's",
    "r at the null, in volts of command: leaks",
    "width of the kink of r at the null",
};

report::Table parameter_table(const identify::Tassa9Fit& fit) {
  report::Table table{.caption = "Parameters and their standard errors",
                      .columns = {"Parameter", "Meaning", "Value", "Standard error", "These logs say"},
                      .rows = {}};
  const auto add = [&](std::string_view name, const char* meaning, const identify::ParameterFit& of) {
    const std::string mark = mark_of(of);
    table.rows.push_back(
        {std::string(name), std::string(meaning), of.value,
         std::isfinite(of.standard_error) ? fmt::format("{:.2g}", of.standard_error) : std::string("-"),
         mark.empty() ? std::string("identifiable") : mark});
  };
  for (std::size_t i = 0; i < identify::kFree; ++i) {
    if (identify::has_parameter(fit.model.form, i))
      add(trace::kTassa9Names[i], kMeanings[i], fit.parameters[i]);
  }
  table.rows.push_back({std::string(trace::kTassa9Names[identify::kFree]),
                        std::string(kMeanings[identify::kFree]), fit.model.c_gamma_V, std::string("-"),
                        std::string("chosen, not fitted")});
  add(trace::kTassa9Names.back(), "from a command to the valve's answer", fit.dead_time);
  return table;
}

report::Table error_table(const Identified& identified) {
  report::Table table{.caption = "RMS error of free runs of 2 s",
                      .columns = {"Log", "", "Free run [kPa]", "Holding the start pressure [kPa]", "Ratio"},
                      .rows = {}};
  const auto add = [&](const NamedLog& of, const char* role) {
    const double free_run_kPa = identify::free_run_rms_kPa(identified.fit.model, of.log, kFreeRun_s);
    const double held_kPa = identify::held_start_rms_kPa(of.log, kFreeRun_s);
    table.rows.push_back({of.name, std::string(role), report::Fixed{free_run_kPa, 2},
                          report::Fixed{held_kPa, 2}, report::Fixed{free_run_kPa / held_kPa, 2}});
  };
  for (const NamedLog& of : identified.fitted) add(of, "fitted");
  for (const NamedLog& of : identified.predicted) add(of, "predicted");
  return table;
}

void add_logs(report::Section& section, const identify::Tassa9& model, const std::vector<NamedLog>& logs) {
  for (const NamedLog& of : logs) {
    report::LineChart pressure =
        free_run_chart(model, of.log, of.name,
                       fmt::format("RMS error {:.3g} kPa; holding the start pressure {:.3g} kPa.",
                                   identify::free_run_rms_kPa(model, of.log, kFreeRun_s),
                                   identify::held_start_rms_kPa(of.log, kFreeRun_s)));
    report::LineChart error =
        free_run_error_chart(model, of.log, fmt::format("Error, {}", of.name), "Predicted minus measured.");
    pressure.group = of.name;
    error.group = of.name;
    section.row({pressure, error});
  }
}

CommandRange commands_of(const std::vector<NamedLog>& logs) {
  CommandRange range{logs.front().log.command_V.front(), logs.front().log.command_V.front()};
  for (const NamedLog& of : logs) {
    const auto [low, high] = std::minmax_element(of.log.command_V.begin(), of.log.command_V.end());
    range = {std::min(range.low_V, *low), std::max(range.high_V, *high)};
  }
  return range;
}

/// A curve for each mean volume among the fitted logs.
std::vector<ModelCurve> by_volume(const Identified& identified) {
  std::vector<ModelCurve> curves;
  for (const NamedLog& of : identified.fitted) {
    const double volume_mL = 1e6 * of.log.mean_volume_m3();
    const bool known = std::any_of(curves.begin(), curves.end(), [&](const ModelCurve& curve) {
      return std::abs(curve.volume_mL - volume_mL) < kSameVolume * volume_mL;
    });
    if (known) continue;
    const std::string name =
        volume_mL < 1e4 ? fmt::format("{:.0f} mL", volume_mL) : fmt::format("{:.1f} L", volume_mL / 1e3);
    curves.push_back({name, identified.fit.model, volume_mL});
  }
  return curves;
}

/// What measured runs of the ventilator can and cannot tell; README.md of host-sim/identify has the figures.
void add_ventilator(report::Page& page) {
  page.section("What these data can and cannot identify")
      .paragraph(
          "Runs of a ventilator on a test lung: inlet and exhaust valve move together and count as one "
          "command of 0 to 10 V; the lung counts as a rigid chamber of equivalent volume.")
      .list({"They can: foretell the airway pressure over 2 s from the command, as the table measures.",
             "Not the supply: it was not recorded, and c1, c2, c3, c7 scale with the one assumed.",
             "Not c4 and c5, held at 0: the equivalent volume does not move.",
             "Not the valves' null: the closed loop never shows it; c1 and c9 end at bounds.",
             "Not resistance: pressure contains resistance times flow, which one equation lacks.",
             "Biased: the loop was closed on this pressure; command and disturbance correlate."});
}

std::string fitted_to(const Identified& identified) {
  return identified.fitted.size() == 1 ? identified.fitted.front().name
                                       : fmt::format("{} logs", identified.fitted.size());
}

}  // namespace

report::Page identify_page(const Identified& identified) {
  const identify::Tassa9Fit& fit = identified.fit;
  const bool repaired = fit.model.form == identify::Form::repaired;
  report::Page page(
      fmt::format("The {}9-parameter model of {}", repaired ? "repaired " : "", fitted_to(identified)));
  page.lead(fmt::format("p' = (s - p) r, with s and r functions of the command: c1 to c9{} fitted {}.{}",
                        repaired ? " but c4" : "",
                        identified.stretch_s > 0.0
                            ? fmt::format("to free runs of {:g} s", identified.stretch_s)
                            : "to the next tick",
                        fit.converged ? "" : fmt::format(" The fit did not converge: {}.", fit.stop)));
  const auto known = std::count_if(fit.parameters.begin(), fit.parameters.end(),
                                   [](const identify::ParameterFit& of) { return of.identifiable; });
  std::vector<report::Tile> tiles{
      {"One step, RMS", to_three_digits(fit.rms_one_step_kPa), "kPa", {}, "on the fitted logs"}};
  if (identified.stretch_s > 0.0) {
    tiles.push_back({"Free run, RMS",
                     to_three_digits(fit.rms_free_run_kPa),
                     "kPa",
                     {},
                     fmt::format("over {:g} s, start estimated", identified.stretch_s)});
  }
  tiles.push_back({"Identifiable", static_cast<double>(known), repaired ? "of 8" : "of 9", {}, "parameters"});
  tiles.push_back({"Condition",
                   to_three_digits(fit.condition),
                   "",
                   {},
                   "of the scaled Jacobian; 1: no parameter acts as others do"});
  tiles.push_back({"c_gamma", fit.model.c_gamma_V, "V", {}, "width of the kink at the null"});
  tiles.push_back({"Samples", static_cast<double>(fit.rows), "", {}, "rows of the fitted logs"});
  page.tiles(std::move(tiles));

  report::Section& errors = page.section("Prediction in free run");
  errors
      .paragraph(
          "The model gets the measured command and volume, and carries its own pressure along; every 2 s it "
          "starts again from the measurement, as in the paper's Fig. 12. Holding the start pressure is what "
          "one can do without any model.")
      .table(error_table(identified));
  if (identified.ventilator) add_ventilator(page);
  if (!identified.predicted.empty()) {
    add_logs(page.section("Logs that the fit has not seen"), fit.model, identified.predicted);
  }
  add_logs(page.section("Fitted logs"), fit.model, identified.fitted);

  report::Section& model = page.section("The model");
  model.paragraph(
      "A chamber's pressure goes to s with rate r; both depend on the command. Drawn over the commands of "
      "the "
      "fitted logs, volume at rest.");
  const std::vector<ModelCurve> curves = by_volume(identified);
  const CommandRange range = commands_of(identified.fitted);
  model.row({steady_chart({{"s", fit.model, curves.front().volume_mL}}, range, ""),
             rate_chart(curves, range, "At the mean volume of the fitted logs.")});
  model.table(parameter_table(fit))
      .note(
          "Standard errors take the prediction errors as white noise; where the model does not fit they are "
          "lower bounds. A parameter at a bound has none: the logs ask for a value outside of what is "
          "admissible, or do not tell.");
  if (fit.rate_not_positive_fraction > 0.0) {
    model.note(fmt::format("At {:.1f} % of the ticks r is not positive, against what the paper asks for.",
                           100.0 * fit.rate_not_positive_fraction));
  }
  return page;
}

}  // namespace plenum::host::tools
