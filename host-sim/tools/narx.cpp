// Models without physics: a linear ARX model and a network that sees the same past, each scored in free run.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/network/narx.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/tools/arguments.hpp"
#include "host-sim/tools/bench_input.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/figures.hpp"
#include "host-sim/tools/model_charts.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

namespace network = identify::network;
using identify::CannotIdentify;
using network::Activation;
using network::Arx;
using network::ArxError;
using network::Narx;

constexpr double kChoosing = 0.25;         // of the rows to fit: their end chooses among the seeds
constexpr double kPeriodTolerance = 1e-3;  // between recordings
constexpr double kLeastF = 10.0;  // of the input: by chance less than one time in 500, whatever the order
constexpr network::Orders kFirst{1, 1};

struct Options {
  std::vector<std::string> logs;
  std::string held_out;
  std::string input = "command_V";
  std::string output_column = "pressure_Pa";
  unsigned order = 3;
  unsigned hidden = 10;
  unsigned seeds = 3;
  std::uint64_t seed = 1;
  int iterations = network::TrainingOptions{}.most_iterations;
  std::string report;
  Output output;

  network::Orders orders() const { return {.outputs = order, .inputs = order}; }
};

struct Log {
  std::string name;
  double period_s = 0.0;
  std::vector<double> inputs{};
  std::vector<double> outputs{};
};

/// Rows of a log from `first`.
struct Stretch {
  const Log* log;
  std::size_t first;
  std::size_t rows;

  std::span<const double> inputs() const { return std::span(log->inputs).subspan(first, rows); }
  std::span<const double> outputs() const { return std::span(log->outputs).subspan(first, rows); }
  /// Without its end, and that end.
  std::pair<Stretch, Stretch> split(double end_share) const {
    const std::size_t kept = rows_before(rows, end_share);
    return {{log, first, kept}, {log, first + kept, rows - kept}};
  }
};

using Stretches = std::vector<Stretch>;

std::vector<network::Recording> recordings(const Stretches& stretches) {
  std::vector<network::Recording> all;
  for (const Stretch& one : stretches) all.push_back({one.inputs(), one.outputs()});
  return all;
}

std::size_t rows_of(const Stretches& stretches) {
  std::size_t sum = 0;
  for (const Stretch& one : stretches) sum += one.rows;
  return sum;
}

template <class Model>
std::vector<std::vector<double>> free_runs(const Model& model, const Stretches& stretches) {
  std::vector<std::vector<double>> runs;
  for (const Stretch& one : stretches) runs.push_back(network::free_run(model, one.inputs(), one.outputs()));
  return runs;
}

/// [%], over all stretches together.
double fit_percent(const Stretches& stretches, const std::vector<std::vector<double>>& runs) {
  std::vector<double> measured;
  std::vector<double> predicted;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const std::span<const double> y = stretches[i].outputs();
    measured.insert(measured.end(), y.begin(), y.end());
    predicted.insert(predicted.end(), runs[i].begin(), runs[i].end());
  }
  return network::fit_percent(measured, predicted);
}

struct Scored {
  std::string key;    ///< in the JSON
  std::string name;   ///< for people
  std::string curve;  ///< the same, short
  double fitted_percent = 0.0;
  double held_out_percent = 0.0;
  std::vector<std::vector<double>> held_out_runs{};
  Figures figures{};                          ///< of a linear model
  std::vector<std::complex<double>> poles{};  ///< of a linear model
};

struct Trained {
  std::uint64_t seed = 0;
  network::NarxFit fit;
  double choosing_percent = 0.0;  ///< of the free run over what chooses among the seeds
};

struct Answer {
  std::vector<Log> logs{};
  std::vector<Log> others{};  ///< with --heldout
  Stretches fitted{};
  Stretches learning{};  ///< of `fitted`, what the sigmoids are trained on
  Stretches choosing{};  ///< the rest of it
  Stretches held_out{};
  std::vector<Scored> models{};  ///< from simple to not so
  double linear_network_off =
      0.0;  ///< of its ARX coefficients, the greatest difference from those of least squares
  std::vector<Trained> trained{};
  std::size_t chosen = 0;

  const Narx& narx() const { return trained[chosen].fit.model; }
};

Log read(const std::string& file, const Options& options) {
  const trace::Recording log = read_bench("narx", file, {"time_s", options.input, options.output_column});
  return {.name = log.name,
          .period_s = trace::period_s(log),
          .inputs = log[options.input],
          .outputs = log[options.output_column]};
}

void read_all(Answer& answer, const Options& options) {
  for (const std::string& file : options.logs) answer.logs.push_back(read(file, options));
  if (!options.held_out.empty()) answer.others.push_back(read(options.held_out, options));
  const double period_s = answer.logs.front().period_s;
  for (const auto* logs : {&answer.logs, &answer.others}) {
    for (const Log& log : *logs) {
      if (std::abs(log.period_s - period_s) <= kPeriodTolerance * period_s) continue;
      throw trace::InputError(fmt::format("{}: a row each {:g} s, expected {:g} s as in {}", log.name,
                                          log.period_s, period_s, answer.logs.front().name));
    }
  }
  for (const Log& log : answer.logs) {
    const Stretch whole{&log, 0, log.outputs.size()};
    const auto [fitted, rest] = whole.split(answer.others.empty() ? kHeldOut : 0.0);
    const auto [learning, choosing] = fitted.split(kChoosing);
    answer.fitted.push_back(fitted);
    answer.learning.push_back(learning);
    answer.choosing.push_back(choosing);
    if (answer.others.empty()) answer.held_out.push_back(rest);
  }
  for (const Log& log : answer.others) answer.held_out.push_back({&log, 0, log.outputs.size()});
}

/// Sees that the free runs can be scored.
void require_scorable(const Stretches& stretches, const char* what, const Options& options) {
  double least = HUGE_VAL;
  double most = -HUGE_VAL;
  for (const Stretch& one : stretches) {
    if (one.rows <= options.order) {
      throw CannotIdentify(fmt::format("{}: {} rows {}, expected more than the order of {}", one.log->name,
                                       one.rows, what, options.order));
    }
    const auto [low, high] = std::ranges::minmax_element(one.outputs());
    least = std::min(least, *low);
    most = std::max(most, *high);
  }
  if (least == most) {
    throw CannotIdentify(fmt::format("{}: {} does not move in the rows {}, so that no free run can be scored",
                                     stretches.front().log->name, options.output_column, what));
  }
}

/// A column as people see it: "pressure_Pa" in kPa; one whose name ends in no unit that is known has none.
struct Shown {
  report::Axis axis;
  double per_unit = 1.0;
};
Shown shown(const std::string& column) {
  if (column.ends_with("_Pa")) return {{column.substr(0, column.size() - 3), "kPa"}, 1e-3};
  for (const std::string unit : {"V", "m", "K", "N"}) {
    if (column.ends_with("_" + unit)) return {{column.substr(0, column.size() - unit.size() - 1), unit}};
  }
  return {{column, ""}};
}

/// Of an output over an input, with the factor from SI.
std::pair<std::string, double> gain_unit(const Options& options) {
  const Shown out = shown(options.output_column);
  const Shown in = shown(options.input);
  const bool known = !out.axis.unit.empty() && !in.axis.unit.empty();
  return {known ? fmt::format("{}/{}", out.axis.unit, in.axis.unit) : "",
          known ? out.per_unit / in.per_unit : 1.0};
}

template <class Model>
Scored scored(std::string key, std::string name, std::string curve, const Model& model,
              const Answer& answer) {
  Scored scored{.key = std::move(key), .name = std::move(name), .curve = std::move(curve)};
  scored.fitted_percent = fit_percent(answer.fitted, free_runs(model, answer.fitted));
  scored.held_out_runs = free_runs(model, answer.held_out);
  scored.held_out_percent = fit_percent(answer.held_out, scored.held_out_runs);
  return scored;
}

Scored linear(std::string key, std::string name, std::string curve, const Arx& arx, const ArxError& error,
              const Answer& answer, const Options& options) {
  Scored model = scored(std::move(key), std::move(name), std::move(curve), arx, answer);
  const double period_s = answer.logs.front().period_s;
  const double T = network::slowest_time_constant(arx);
  const std::string unstable = T > 0.0 ? "" : "the model is not stable";
  const auto [gain, per_gain] = gain_unit(options);
  model.figures = {
      {"static_gain", "static gain", gain, per_gain, network::static_gain(arx), error.static_gain, unstable},
      {"time_constant_s", "slowest time constant", "s", 1.0, period_s * T,
       period_s * error.slowest_time_constant, unstable}};
  const auto add = [&](const char* letter, const std::string& unit, double per_unit,
                       const std::vector<double>& values, const std::vector<double>& errors) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      model.figures.push_back({fmt::format("{}{}", letter, i + 1), fmt::format("{}_{}", letter, i + 1), unit,
                               per_unit, values[i], errors[i]});
    }
  };
  add("a", "", 1.0, arx.outputs, error.outputs);
  add("b", gain, per_gain, arx.inputs, error.inputs);
  const Shown out = shown(options.output_column);
  model.figures.push_back({"c", "c", out.axis.unit, out.per_unit, arx.constant, error.constant});
  const Eigen::VectorXcd z = network::poles(arx);
  model.poles.assign(z.begin(), z.end());
  std::ranges::sort(model.poles, [](const auto& p, const auto& q) {
    return std::pair(std::abs(p), p.imag()) > std::pair(std::abs(q), q.imag());
  });
  return model;
}

/// Of the coefficients of past outputs and of past inputs, as a share of the greatest of either.
double greatest_difference(const Arx& a, const Arx& b) {
  double share = 0.0;
  for (const auto part : {&Arx::outputs, &Arx::inputs}) {
    double off = 0.0;
    double most = 0.0;
    for (std::size_t i = 0; i < (a.*part).size(); ++i) {
      off = std::max(off, std::abs((a.*part)[i] - (b.*part)[i]));
      most = std::max(most, std::abs((a.*part)[i]));
    }
    share = std::max(share, off / most);
  }
  return share;
}

void train(Answer& answer, const Arx& arx, const Options& options) {
  const auto hidden = static_cast<Eigen::Index>(options.hidden);
  const network::TrainingOptions training{.most_iterations = options.iterations};
  Progress progress("training");
  const double runs = 1.0 + options.seeds;
  const std::vector<network::Recording> all = recordings(answer.fitted);
  answer.linear_network_off = greatest_difference(
      arx, network::arx_of(network::fit_narx(all, options.orders(), hidden, Activation::kLinear, options.seed,
                                             training, [&](double share) { progress(share / runs); })
                               .model));
  for (unsigned i = 0; i < options.seeds; ++i) {
    const std::uint64_t seed = options.seed + i;
    Trained trained{
        .seed = seed,
        .fit = network::fit_narx(recordings(answer.learning), options.orders(), hidden, Activation::kSigmoid,
                                 seed, training, [&](double share) { progress((1.0 + i + share) / runs); })};
    trained.choosing_percent = fit_percent(answer.choosing, free_runs(trained.fit.model, answer.choosing));
    answer.trained.push_back(std::move(trained));
    if (answer.trained[i].choosing_percent > answer.trained[answer.chosen].choosing_percent)
      answer.chosen = i;
  }
}

void require_input_that_tells(double F, const Options& options) {
  if (F >= kLeastF) return;
  throw CannotIdentify(fmt::format(
      "{} does not tell {} (F of its {} past rows {:.2g}, expected {:g} or more): is it what drives, "
      "and --order as long as the delay?",
      options.input, options.output_column, options.order, F, kLeastF));
}

void identify_all(Answer& answer, const Options& options) {
  require_scorable(answer.fitted, "to fit", options);
  require_scorable(answer.choosing, "that choose among the seeds", options);
  require_scorable(answer.held_out, "held out", options);
  try {
    const std::vector<network::Recording> rows = recordings(answer.fitted);
    const ArxError error = network::arx_error(rows, options.orders());
    require_input_that_tells(error.input_F, options);
    const Arx arx = network::fit_arx(rows, options.orders());
    answer.models.push_back(linear("first_order", "first-order lag", "lag", network::fit_arx(rows, kFirst),
                                   network::arx_error(rows, kFirst), answer, options));
    answer.models.push_back(
        linear("arx", fmt::format("ARX, order {}", options.order), "ARX", arx, error, answer, options));
    train(answer, arx, options);
  } catch (const CannotIdentify& why) {
    std::vector<std::string> names;
    for (const Log& log : answer.logs) names.push_back(log.name);
    throw CannotIdentify(fmt::format("{}: {}", fmt::join(names, ", "), why.what()));
  }
  answer.models.push_back(scored("narx",
                                 fmt::format("NARX, order {}, {} sigmoids", options.order, options.hidden),
                                 "NARX", answer.narx(), answer));
}

std::string percent(double fit) {
  return std::isfinite(fit) ? fmt::format("{:.2f} %", fit) : "none, it leaves all bounds";
}

/// Of a free run.
bool worse_than_mean(double fit) {
  return fit < 0.0;
}

std::string pole_text(std::complex<double> z) {
  return z.imag() == 0.0 ? fmt::format("{:.5g}", z.real())
                         : fmt::format("{:.5g}{:+.5g}i", z.real(), z.imag());
}

void print(const Options& options, const Answer& answer) {
  const Output& output = options.output;
  const double period_s = answer.logs.front().period_s;
  output.print("{} from {}, {} recording{} at {:.4g} Hz; fitted {:.4g} s, held out {:.4g} s\n",
               options.output_column, options.input, answer.logs.size(), answer.logs.size() == 1 ? "" : "s",
               1.0 / period_s, period_s * static_cast<double>(rows_of(answer.fitted)),
               period_s * static_cast<double>(rows_of(answer.held_out)));
  output.print("fits of free runs, held out (of what was fitted):\n");
  for (const Scored& of : answer.models)
    output.print("  {:<32} {} ({}){}\n", of.name, percent(of.held_out_percent), percent(of.fitted_percent),
                 worse_than_mean(of.held_out_percent) ? ": worse than the mean, do not use it" : "");
  for (const Scored& of : answer.models) {
    if (of.figures.empty()) continue;
    output.print("{}:\n", of.name);
    print(output, of.figures, 2);
    std::vector<std::string> poles;
    for (const std::complex<double>& z : of.poles) poles.push_back(pole_text(z));
    output.print("  poles z = {}\n", fmt::join(poles, ", "));
  }
  output.print(
      "a network of {} linear units has the coefficients of the ARX model but for {:.1g} of the greatest\n",
      options.hidden, answer.linear_network_off);
  output.print("training of the sigmoids:\n");
  for (std::size_t i = 0; i < answer.trained.size(); ++i) {
    const Trained& of = answer.trained[i];
    output.print("  seed {}: fit {} on the validation quarter, {} iterations: {}{}\n", of.seed,
                 percent(of.choosing_percent), of.fit.training.iterations, of.fit.training.stop,
                 i == answer.chosen ? "; chosen" : "");
  }
}

Json json_of(const network::Scaling& of) {
  return {{"mean", of.mean}, {"deviation", of.deviation}};
}

Json json_of(const Stretches& stretches) {
  Json json = Json::array();
  for (const Stretch& one : stretches)
    json.push_back({{"file", one.log->name}, {"from_row", one.first + 1}, {"rows", one.rows}});
  return json;
}

Json json_of(const Options& options, const Answer& answer) {
  Json json{{"schema", "plenum-narx/1"},
            {"input", options.input},
            {"output", options.output_column},
            {"order", options.order},
            {"period_s", answer.logs.front().period_s},
            {"fitted", json_of(answer.fitted)},
            {"held_out", json_of(answer.held_out)}};
  for (const Scored& of : answer.models) {
    Json& model = json[of.key];
    model = {{"held_out_fit_percent", number(of.held_out_percent)},
             {"fitted_fit_percent", number(of.fitted_percent)}};
    if (of.figures.empty()) continue;
    model["parameters"] = to_json(of.figures);
    model["poles"] = Json::array();
    for (const std::complex<double>& z : of.poles) model["poles"].push_back({z.real(), z.imag()});
  }
  json["arx"]["linear_network_difference"] = number(answer.linear_network_off);
  Json& narx = json["narx"];
  narx["hidden"] = options.hidden;
  narx["output_scaling"] = json_of(answer.narx().output);
  narx["input_scaling"] = json_of(answer.narx().input);
  const Eigen::VectorXd& weights = answer.narx().network.weights();
  narx["weights"] = std::vector<double>(weights.begin(), weights.end());
  narx["chosen_seed"] = answer.trained[answer.chosen].seed;
  narx["seeds"] = Json::array();
  for (const Trained& of : answer.trained) {
    narx["seeds"].push_back({{"seed", of.seed},
                             {"choosing_fit_percent", number(of.choosing_percent)},
                             {"iterations", of.fit.training.iterations},
                             {"stop", of.fit.training.stop}});
  }
  return json;
}

void add_held_out(report::Page& page, const Options& options, const Answer& answer, std::size_t i) {
  const Stretch& rows = answer.held_out[i];
  const std::span<const double> y = rows.outputs();
  const std::span<const double> u = rows.inputs();
  const Shown out = shown(options.output_column);
  const Shown in = shown(options.input);
  const std::vector<double> time_s = times_s(rows.rows, rows.log->period_s, rows.first);
  report::LineChart runs{
      .title = "Free runs",
      .caption =
          fmt::format("From the first {} rows on each model is fed with its own outputs.", options.order),
      .y = out.axis,
      .curves = {{"measured", time_s, scaled({y.begin(), y.end()}, out.per_unit), report::Stroke::kSolid,
                  report::Ink::kNeutral}},
      .group = rows.log->name};
  report::LineChart errors{
      .title = "Error", .caption = "Free run minus measured.", .y = out.axis, .group = rows.log->name};
  for (const Scored& of : answer.models) {
    if (!std::isfinite(of.held_out_percent)) continue;
    const std::vector<double>& run = of.held_out_runs[i];
    std::vector<double> error(run.size());
    for (std::size_t k = 0; k < run.size(); ++k) error[k] = out.per_unit * (run[k] - y[k]);
    runs.curves.push_back({of.curve, time_s, scaled(run, out.per_unit)});
    errors.curves.push_back({of.curve, time_s, std::move(error)});
  }
  page.section(fmt::format("{}: held out", rows.log->name))
      .row({std::move(runs), std::move(errors)})
      .chart(
          report::LineChart{.title = "Input",
                            .y = in.axis,
                            .curves = {{in.axis.quantity, time_s, scaled({u.begin(), u.end()}, in.per_unit),
                                        report::Stroke::kSteps}},
                            .group = rows.log->name});
}

report::Page page_of(const Options& options, const Answer& answer) {
  report::Page page("Models without physics: ARX and NARX");
  page.lead(
      fmt::format("{} from {}: linear in its past (ARX), and by a network of {} sigmoids of the same past "
                  "(NARX). Both are "
                  "fitted one sample ahead; they are scored in free run, fed with their own outputs, on rows "
                  "that neither has "
                  "seen. 100 % is exact, 0 % as good as the mean.",
                  options.output_column, options.input, options.hidden));
  std::vector<report::Tile> tiles;
  report::Table scores{
      .caption = "Fit of free runs", .columns = {"Model", "Held out", "Of what was fitted"}, .rows = {}};
  for (const Scored& of : answer.models) {
    tiles.push_back(
        {of.name,
         of.held_out_percent,
         "%",
         {},
         worse_than_mean(of.held_out_percent) ? "held out: worse than the mean, do not use it" : "held out"});
    scores.rows.push_back({of.name, percent(of.held_out_percent), percent(of.fitted_percent)});
  }
  page.tiles(std::move(tiles));
  page.section("Scores").table(std::move(scores));
  for (std::size_t i = 0; i < answer.held_out.size(); ++i) add_held_out(page, options, answer, i);
  for (const Scored& of : answer.models) {
    if (of.figures.empty()) continue;
    report::Table poles{
        .caption = "Poles", .columns = {"z", "Magnitude", "Time constant [s]", "Frequency [Hz]"}, .rows = {}};
    const double period_s = answer.logs.front().period_s;
    for (const std::complex<double>& z : of.poles) {
      poles.rows.push_back({pole_text(z), std::abs(z), -period_s / std::log(std::abs(z)),
                            std::abs(std::arg(z)) / (2.0 * std::numbers::pi * period_s)});
    }
    page.section(of.name)
        .paragraph(
            "Standard errors take the errors of the equation as white; noise of the measured past biases "
            "the coefficients beyond them.")
        .table(table_of(of.figures, fmt::format("{} rows to fit", rows_of(answer.fitted))))
        .table(std::move(poles));
  }
  report::Table seeds{
      .caption = "Trained on three quarters of the rows to fit; the last, the validation quarter, chooses",
      .columns = {"Seed", "Fit on the validation quarter", "Iterations", "Stopped because", "Chosen"},
      .rows = {}};
  for (std::size_t i = 0; i < answer.trained.size(); ++i) {
    const Trained& of = answer.trained[i];
    seeds.rows.push_back({fmt::format("{}", of.seed), percent(of.choosing_percent),
                          fmt::format("{}", of.fit.training.iterations), of.fit.training.stop,
                          i == answer.chosen ? "chosen" : ""});
  }
  page.section(answer.models.back().name).table(std::move(seeds));
  return page;
}

int run(const Options& options) {
  if (options.input == options.output_column) {
    throw std::invalid_argument(
        fmt::format("--input {0}, --output {0}: expected two different columns", options.input));
  }
  Answer answer;
  read_all(answer, options);
  identify_all(answer, options);
  print(options, answer);
  write_report(options.output, options.report, [&] { return page_of(options, answer); });
  options.output.finish(json_of(options, answer));
  return kDone;
}

}  // namespace

Command add_narx(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "narx", "Fit models without physics to logs: a linear ARX one and a network, scored in free run");
  arguments
      .option("LOG", options->logs,
              "Recordings with the columns time_s, that of --input and that of --output, at one period")
      .type_name("LOG.csv")
      .required();
  arguments
      .option("--heldout", options->held_out,
              "Another recording to score the free runs on (default: the last 40 % of each LOG is held out)")
      .type_name("HELD.csv");
  arguments.option("--input", options->input, "Column that drives, each value held from its row to the next")
      .type_name("NAME")
      .show_default();
  arguments.option("--output", options->output_column, "Column that is driven")
      .type_name("NAME")
      .show_default();
  arguments.option("--order", options->order, "Past inputs, and past outputs, that the models see")
      .within(1U, 20U)
      .show_default();
  arguments.option("--hidden", options->hidden, "Sigmoids of the network").within(1U, 50U).show_default();
  arguments
      .option("--seeds", options->seeds,
              "Networks trained, from random weights each: the best on the last quarter of the rows to fit, "
              "kept from "
              "training, is taken")
      .within(1U, 100U)
      .show_default();
  arguments.option("--seed", options->seed, "Of the first network; the next has the next").show_default();
  arguments.option("--iterations", options->iterations, "Of Levenberg-Marquardt at most")
      .within(1, 100000)
      .show_default();
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(
      example("  plenum narx --input command_V --output position_m run-1.csv run-2.csv --report narx.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
