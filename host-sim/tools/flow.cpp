// A valve port from a table of its flow: the bipolynomial of the servo paper, and the orifice beside it.
#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/servo/bipolynomial.hpp"
#include "host-sim/identify/servo/parabolic_orifice.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/tools/arguments.hpp"
#include "host-sim/tools/bench_input.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"

namespace plenum::host::tools {
namespace {

namespace servo = identify::servo;
using servo::FlowError;
using servo::FlowSample;

constexpr double kMost_kg_s = 10.0;    // more is another unit
constexpr std::size_t kMostDrawn = 6;  // commands of a chart

struct Options {
  std::string table;
  std::string port = "inlet";
  double supply_kPa = 700.0;
  double ambient_kPa = 101.325;
  std::string report;
  Output output;

  servo::Port flow_port() const { return {port == "inlet", 1e3 * supply_kPa, 1e3 * ambient_kPa}; }
};

using Law = std::function<double(double command_V, double pressure_Pa)>;

/// A law fitted to samples: the law, its coefficients as the JSON has them, and how it errs on the samples.
struct Fitted {
  Law flow_kg_s;
  Json coefficients;
  FlowError error;
};

/// One kind of law.
struct Kind {
  const char* key;   ///< in the JSON
  const char* name;  ///< in print and on pages
  std::function<Fitted(const std::vector<FlowSample>&)> fit;
};

std::vector<Kind> kinds(const servo::Port& port) {
  const auto bipolynomial = [](servo::Terms terms) {
    return [terms](const std::vector<FlowSample>& samples) {
      const servo::BipolynomialFit fit = servo::fit_bipolynomial(samples, terms);
      return Fitted{[law = fit.polynomial](double u, double P) { return law.flow_kg_s(u, P); },
                    {{"kg_s_by_V_Pa", fit.polynomial.c}},
                    fit};
    };
  };
  return {{"bipolynomial", "bipolynomial, 9 terms", bipolynomial(servo::Terms::kWhole)},
          {"bipolynomial_as_printed", "(5) as printed, 8 terms", bipolynomial(servo::Terms::kAsPrinted)},
          {"orifice", "orifice (2), area a parabola", [port](const std::vector<FlowSample>& samples) {
             const servo::ParabolicOrificeFit fit = servo::fit_parabolic_orifice(samples, port);
             return Fitted{[law = fit.orifice](double u, double P) { return law.flow_kg_s(u, P); },
                           {{"m2_by_V", fit.orifice.area_m2}},
                           fit};
           }}};
}

struct Scored {
  Kind kind;
  Fitted fitted;
  std::optional<FlowError>
      between;  ///< each inner command predicted from the others; none of fewer than five
};

struct Answer {
  std::string name;
  std::vector<FlowSample> samples;
  std::vector<double> commands_V;  ///< those of the samples, rising
  std::vector<Scored> laws;
};

std::vector<double> distinct(const std::vector<FlowSample>& samples) {
  std::vector<double> commands_V;
  commands_V.reserve(samples.size());
  for (const FlowSample& s : samples) commands_V.push_back(s.command_V);
  std::sort(commands_V.begin(), commands_V.end());
  commands_V.erase(std::unique(commands_V.begin(), commands_V.end()), commands_V.end());
  return commands_V;
}

/// Leaving one command out leaves a parabola three and one more, so that it cannot simply pass through them.
constexpr std::size_t kLeastCommands = 5;

std::optional<FlowError> error_between(const Kind& kind, const Answer& answer) {
  if (answer.commands_V.size() < kLeastCommands) return {};
  std::vector<FlowSample> left_out;
  std::vector<double> predicted;
  for (std::size_t i = 1; i + 1 < answer.commands_V.size(); ++i) {
    std::vector<FlowSample> others;
    std::copy_if(answer.samples.begin(), answer.samples.end(), std::back_inserter(others),
                 [&](const FlowSample& s) { return s.command_V != answer.commands_V[i]; });
    const Fitted fitted = kind.fit(others);
    for (const FlowSample& s : answer.samples) {
      if (s.command_V != answer.commands_V[i]) continue;
      left_out.push_back(s);
      predicted.push_back(fitted.flow_kg_s(s.command_V, s.pressure_Pa));
    }
  }
  return servo::flow_error(left_out, predicted);
}

Answer identified(const Options& options) {
  const trace::Recording table = read_bench("flow", options.table, {"command_V", "pressure_Pa", "flow_kg_s"});
  require_absolute_pressure(table, "pressure_Pa", 1e3 * options.ambient_kPa);
  require_between(table, "flow_kg_s", -kMost_kg_s, kMost_kg_s, "kg/s, up to 10 either way");
  Answer answer{.name = table.name, .samples = {}, .commands_V = {}, .laws = {}};
  for (std::size_t i = 0; i < table.rows; ++i)
    answer.samples.push_back({table["command_V"][i], table["pressure_Pa"][i], table["flow_kg_s"][i]});
  answer.commands_V = distinct(answer.samples);
  told_of(answer.name, [&] {
    for (Kind& kind : kinds(options.flow_port())) {
      Fitted fitted = kind.fit(answer.samples);
      if (fitted.error.full_scale_kg_s == 0.0) throw identify::CannotIdentify("nothing flows");
      std::optional<FlowError> between = error_between(kind, answer);
      answer.laws.push_back({std::move(kind), std::move(fitted), between});
    }
  });
  return answer;
}

double percent(double error_kg_s, const Answer& answer) {
  return 100.0 * error_kg_s / answer.laws.front().fitted.error.full_scale_kg_s;
}

double between_percent(const Scored& law, const Answer& answer) {
  return law.between ? percent(law.between->rms_kg_s, answer) : std::numeric_limits<double>::quiet_NaN();
}

void print(const Options& options, const Answer& answer) {
  const Output& output = options.output;
  output.print("{}: {}, {} samples at {} commands, {:.4g} g/s at most\n", answer.name, options.port,
               answer.samples.size(), answer.commands_V.size(),
               1e3 * answer.laws.front().fitted.error.full_scale_kg_s);
  output.print("  {:<30} {:>8} {:>8} {:>10} {:>10}\n", "error, % of that", "RMS", "largest", "between",
               "wrong way");
  for (const Scored& law : answer.laws) {
    output.print("  {:<30} {:>8.3g} {:>8.3g} {:>10} {:>10}\n", law.kind.name,
                 percent(law.fitted.error.rms_kg_s, answer), percent(law.fitted.error.largest_kg_s, answer),
                 law.between ? fmt::format("{:.3g}", between_percent(law, answer)) : "-",
                 law.fitted.error.wrong_way);
  }
  output.print(
      "between: RMS of each inner command as predicted from the others; wrong way: samples where the valve "
      "flows "
      "the other way or not at all\n");
}

Json json_of(const Options& options, const Answer& answer) {
  Json json{{"schema", "plenum-flow/1"},
            {"file", answer.name},
            {"port", options.port},
            {"samples", answer.samples.size()},
            {"commands", answer.commands_V.size()},
            {"full_scale_kg_s", answer.laws.front().fitted.error.full_scale_kg_s},
            {"laws", Json::object()}};
  for (const Scored& law : answer.laws) {
    Json& entry = json["laws"][law.kind.key];
    entry = law.fitted.coefficients;
    entry["rms_kg_s"] = law.fitted.error.rms_kg_s;
    entry["largest_kg_s"] = law.fitted.error.largest_kg_s;
    entry["between_rms_kg_s"] = number(law.between ? std::optional(law.between->rms_kg_s) : std::nullopt);
    entry["wrong_way"] = law.fitted.error.wrong_way;
  }
  return json;
}

report::XyChart drawn(const Answer& answer, const Scored& law) {
  report::XyChart chart{.title = law.kind.name,
                        .caption = fmt::format("{:.3g} % of full scale RMS, {:.3g} % at most.",
                                               percent(law.fitted.error.rms_kg_s, answer),
                                               percent(law.fitted.error.largest_kg_s, answer)),
                        .x = {"Chamber pressure", "kPa"},
                        .y = {"Mass flow", "g/s"}};
  const std::size_t every = (answer.commands_V.size() + kMostDrawn - 1) / kMostDrawn;
  for (std::size_t i = 0; i < answer.commands_V.size(); i += every) {
    const double command_V = answer.commands_V[i];
    report::Curve measured{.name = "measured",
                           .x = {},
                           .y = {},
                           .stroke = report::Stroke::kPoints,
                           .ink = report::Ink::kNeutral};
    for (const FlowSample& s : answer.samples) {
      if (s.command_V != command_V) continue;
      measured.x.push_back(1e-3 * s.pressure_Pa);
      measured.y.push_back(1e3 * s.flow_kg_s);
    }
    report::Curve fitted{.name = fmt::format("{:.3g} V", command_V), .x = measured.x, .y = {}};
    std::sort(fitted.x.begin(), fitted.x.end());
    for (const double P_kPa : fitted.x)
      fitted.y.push_back(1e3 * law.fitted.flow_kg_s(command_V, 1e3 * P_kPa));
    chart.curves.push_back(std::move(measured));
    chart.curves.push_back(std::move(fitted));
  }
  return chart;
}

report::Page page_of(const Options& options, const Answer& answer) {
  report::Page page("Flow of a valve port");
  page.lead(
      fmt::format("{}, {}: mass flow over chamber pressure and command, by a polynomial of second order in "
                  "both, and by an "
                  "orifice whose area is a parabola in the command.",
                  answer.name, options.port));
  std::vector<report::Tile> tiles;
  report::Table table{.caption = fmt::format("Errors in % of {:.4g} g/s",
                                             1e3 * answer.laws.front().fitted.error.full_scale_kg_s),
                      .columns = {"Law", "RMS", "Largest", "Between commands, RMS", "Samples the wrong way"},
                      .rows = {}};
  for (const Scored& law : answer.laws) {
    tiles.push_back({law.kind.name, percent(law.fitted.error.rms_kg_s, answer), "% RMS"});
    table.rows.push_back({law.kind.name, percent(law.fitted.error.rms_kg_s, answer),
                          percent(law.fitted.error.largest_kg_s, answer), between_percent(law, answer),
                          static_cast<double>(law.fitted.error.wrong_way)});
  }
  page.tiles(std::move(tiles));
  report::Section& section = page.section("Laws").table(std::move(table));
  for (const Scored& law : answer.laws) section.chart(drawn(answer, law));
  return page;
}

int run(const Options& options) {
  require_order("--ambient", options.ambient_kPa, "--supply", options.supply_kPa, "kPa");
  const Answer answer = identified(options);
  print(options, answer);
  write_report(options.output, options.report, [&] { return page_of(options, answer); });
  options.output.finish(json_of(options, answer));
  return kDone;
}

}  // namespace

Command add_flow(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("flow", "Fit laws of flow to a table of a valve port's, measured on a bench");
  arguments
      .option(
          "TABLE", options->table,
          "Samples at rest, in any order: the columns command_V, pressure_Pa (of the chamber, absolute) and "
          "flow_kg_s (through the port)")
      .type_name("TABLE.csv")
      .required();
  arguments
      .option("--port", options->port,
              "inlet: from the supply into the chamber; exhaust: from the chamber out")
      .one_of({"inlet", "exhaust"})
      .show_default();
  arguments.option("--supply", options->supply_kPa, "Absolute [kPa]").within(1.0, 1e5).show_default();
  arguments.option("--ambient", options->ambient_kPa, "Absolute [kPa]").within(1.0, 1e4).show_default();
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum flow inlet.csv --supply 700 --report flow.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
