// A pressure regulator valve from a staircase of its screw: third-order models of either direction, dead band, inside.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/fit_measure.hpp"
#include "host-sim/identify/regulator_valve/internal_parameters.hpp"
#include "host-sim/identify/regulator_valve/least_squares.hpp"
#include "host-sim/identify/regulator_valve/model_error.hpp"
#include "host-sim/identify/regulator_valve/piecewise.hpp"
#include "host-sim/identify/regulator_valve/swarm_fit.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/tools/arguments.hpp"
#include "host-sim/tools/bench_input.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/figures.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"

namespace plenum::host::tools {
namespace {

namespace valve = identify::regulator_valve;
using plant::regulator_valve::Recording;
using valve::Branch;
using valve::Direction;
using valve::DiscreteModel;

constexpr double kBlocked = 0.528;        // (10): both ports are blocked from p_atm/r to r p_sup
constexpr double kLongestTravel_m = 0.1;  // of a screw: more is another unit
constexpr double kResolved = 0.5;       // |z - 1| of a pole that a forward difference still takes for |s| t_s
constexpr std::size_t kFewestHeld = 8;  // rows of a position that is held

struct Options {
  std::string log;
  std::string held_out;
  std::string method = "both";
  double supply_kPa = 800.0;
  double ambient_kPa = 101.325;
  std::optional<double> low_kPa;
  std::optional<double> high_kPa;
  std::uint64_t seed = 1;
  bool internal = false;
  double volume_mL = 1e6 * valve::SystemConstants{}.volume_m3;
  double plunger_damping_N_s_m = valve::SystemConstants{}.plunger_damping_N_s_m;
  double spool_damping_N_s_m = valve::SystemConstants{}.spool_damping_N_s_m;
  double rest_screw_mm = 1e3 * valve::SystemConstants{}.rest_screw_m;
  std::string report;
  Output output;

  double ambient_Pa() const { return 1e3 * ambient_kPa; }
  /// Gauge.
  valve::PressureRange range() const {
    return {.low_Pa = 1e3 * low_kPa.value_or(ambient_kPa / kBlocked) - ambient_Pa(),
            .high_Pa = 1e3 * high_kPa.value_or(kBlocked * supply_kPa) - ambient_Pa()};
  }
};

struct Named {
  std::string name;
  Recording recording;
  std::size_t positions = 0;  ///< held
};

Named read(const std::string& file, const Options& options) {
  const trace::Recording log = read_bench("regulator", file, {"time_s", "screw_m", "pressure_Pa"});
  require_between(log, "screw_m", -kLongestTravel_m, kLongestTravel_m,
                  fmt::format("m, up to {:g} either way", kLongestTravel_m));
  require_absolute_pressure(log, "pressure_Pa", options.ambient_Pa());
  Named named{
      .name = log.name,
      .recording = {
          .sample_s = trace::period_s(log), .screw_m = log["screw_m"], .pressure_Pa = log["pressure_Pa"]}};
  for (double& p : named.recording.pressure_Pa) p -= options.ambient_Pa();
  std::size_t longest = 0;
  for (const valve::Plateau& at : valve::plateaus(named.recording)) {
    longest = std::max(longest, at.end - at.first);
    named.positions += at.end - at.first >= kFewestHeld ? 1 : 0;
  }
  if (longest < kFewestHeld) {
    throw identify::CannotIdentify(fmt::format(
        "{}: screw_m is held for {} rows at most, expected a staircase: the position as commanded, "
        "each held until the pressure has settled",
        named.name, longest));
  }
  return named;
}

struct Fitted {
  const char* method;  ///< ls, pso
  DiscreteModel model{};
  valve::ModelError error{};
  double fit_percent = 0.0;  ///< (39) of the free run over the rows that were fitted
  double held_out_percent = 0.0;
  std::vector<double> held_out_Pa{};  ///< free run, deviations from the rest before the fit
};

/// One direction of the screw.
struct Side {
  Direction direction;
  Branch fitted{};
  Branch held_out{};  ///< deviations from the rest of `fitted`
  std::vector<Fitted> models{};

  const char* name() const { return direction == Direction::kRising ? "rising" : "falling"; }
};

/// Rows [first, first + rows) of a recording as deviations from `rest`.
Branch about(const valve::Plateau& rest, const Recording& recording, std::size_t first, std::size_t rows) {
  Branch branch = valve::zero_mean(recording, first, first + rows);
  for (double& x : branch.screw_m) x += branch.mean_screw_m - rest.screw_m;
  for (double& p : branch.pressure_Pa) p += branch.mean_pressure_Pa - rest.settled_Pa;
  branch.mean_screw_m = rest.screw_m;
  branch.mean_pressure_Pa = rest.settled_Pa;
  return branch;
}

/// The position at whose end a branch begins. Deviations count from there and not, as in the paper, from the
/// means: of steps that take their time the mean pressure is not that of the mean screw, and a model without an offset
/// then comes out too fast.
valve::Plateau rest_before(const Recording& recording, const Branch& branch) {
  const std::vector<valve::Plateau> all = valve::plateaus(recording);
  return *std::find_if(all.begin(), all.end(),
                       [&](const valve::Plateau& at) { return branch.first < at.end; });
}

Side side_of(const Named& log, const std::optional<Named>& other, Direction direction,
             const valve::PressureRange& range) {
  const Branch whole = valve::branch_of(log.recording, direction, range);
  const valve::Plateau rest = rest_before(log.recording, whole);
  const std::size_t rows = whole.screw_m.size();
  const std::size_t kept = rows_before(rows, other ? 0.0 : kHeldOut);
  Side side{.direction = direction, .fitted = about(rest, log.recording, whole.first, kept)};
  if (other) {
    const Branch branch = valve::branch_of(other->recording, direction, range);
    side.held_out = about(rest, other->recording, branch.first, branch.screw_m.size());
  } else {
    side.held_out = about(rest, log.recording, whole.first + kept, rows - kept);
  }
  return side;
}

double fit_of(const Branch& branch, const std::vector<double>& run) {
  return valve::fit_percent(branch.pressure_Pa, run);
}

Fitted scored(const char* method, const DiscreteModel& model, const valve::ModelError& error,
              const Side& side) {
  Fitted fitted{.method = method, .model = model, .error = error};
  fitted.fit_percent =
      fit_of(side.fitted, valve::free_run(model, side.fitted.screw_m, side.fitted.pressure_Pa));
  return fitted;
}

void score_held_out(Side& side, const Named& judged) {
  told_of(fmt::format("{}: {} branch, held out", judged.name, side.name()), [&] {
    for (Fitted& of : side.models) {
      of.held_out_Pa = valve::free_run(of.model, side.held_out.screw_m, side.held_out.pressure_Pa);
      of.held_out_percent = fit_of(side.held_out, of.held_out_Pa);
    }
  });
}

void fit(Side& side, const Named& log, const Options& options) {
  told_of(fmt::format("{}: {} branch", log.name, side.name()), [&] {
    if (options.method != "pso") {
      const DiscreteModel model = valve::fit_least_squares(side.fitted);
      side.models.push_back(scored("ls", model, valve::one_step_error(model, side.fitted), side));
    }
    if (options.method != "ls") {
      Progress progress(fmt::format("{} branch, particle swarm", side.name()));
      const DiscreteModel model =
          valve::fit_swarm(side.fitted, {.seed = options.seed}, [&](double share) { progress(share); }).model;
      side.models.push_back(scored("pso", model, valve::free_run_error(model, side.fitted), side));
    }
  });
}

/// The model of three conditions over the log that it is judged on.
struct Whole {
  valve::DeadBand dead_band;
  std::size_t first = 0;           ///< row of that log from which it runs
  std::vector<double> gauge_Pa{};  ///< from there to the log's end
  double fit_percent = 0.0;        ///< over the rows of them that lie in the range
};

Whole run_whole(const Side& rising, const Side& falling, const Named& log, const Named& judged,
                const valve::PressureRange& range) {
  const auto centered = [](const Side& side) {
    return valve::CenteredModel{side.models.back().model, side.fitted.mean_screw_m,
                                side.fitted.mean_pressure_Pa};
  };
  Whole whole{.dead_band = valve::measure_dead_band(log.recording, range)};
  const Branch start = valve::branch_of(judged.recording, Direction::kRising, range);
  whole.first = start.first;
  const std::vector<double>& screw_m = judged.recording.screw_m;
  const std::vector<double>& gauge_Pa = judged.recording.pressure_Pa;
  double start_Pa = 0.0;
  std::size_t resting = 0;
  while (screw_m[start.first + resting] == screw_m[start.first])
    start_Pa += gauge_Pa[start.first + resting++];
  whole.gauge_Pa =
      valve::predict({centered(rising), centered(falling), std::max(0.0, whole.dead_band.width_m)},
                     {screw_m.begin() + static_cast<std::ptrdiff_t>(whole.first), screw_m.end()},
                     start_Pa / static_cast<double>(resting));
  std::vector<double> measured;
  std::vector<double> predicted;
  for (std::size_t k = 0; k < whole.gauge_Pa.size(); ++k) {
    const double p = gauge_Pa[whole.first + k];
    if (p < range.low_Pa || p > range.high_Pa) continue;
    measured.push_back(p);
    predicted.push_back(whole.gauge_Pa[k]);
  }
  told_of(fmt::format("{}: rows in the range", judged.name),
          [&] { whole.fit_percent = valve::fit_percent(measured, predicted); });
  return whole;
}

Figures figures_of(const Fitted& of) {
  const DiscreteModel& model = of.model;
  return {{"static_gain_Pa_m", "static gain", "kPa/mm", 1e-6, model.static_gain_Pa_m(),
           of.error.static_gain_Pa_m},
          {"time_constant_s", "slowest time constant", "s", 1.0, valve::slowest_time_constant_s(model),
           of.error.slowest_time_constant_s, valve::stable(model) ? "" : "the model is not stable"},
          {"b_Pa_m", "b", "kPa/mm", 1e-6, model.b_Pa_m, of.error.coefficient(3)},
          {"a1", "a_1", "", 1.0, model.a[0], of.error.coefficient(0)},
          {"a2", "a_2", "", 1.0, model.a[1], of.error.coefficient(1)},
          {"a3", "a_3", "", 1.0, model.a[2], of.error.coefficient(2)}};
}

/// Empty where (32) can be solved for the poles of both models: it takes them for s = (z - 1)/t_s.
std::string unresolved(const Fitted& up, const Fitted& down) {
  double fastest = 0.0;
  for (const Fitted* of : {&up, &down})
    for (const std::complex<double>& z : valve::poles(of->model))
      fastest = std::max(fastest, std::abs(z - 1.0));
  return fastest < kResolved
             ? std::string()
             : fmt::format("a pole of {:.2g} samples: the sample time is too long for it", 1.0 / fastest);
}

Figures inside(const Side& rising, const Side& falling, const Options& options) {
  valve::SystemConstants constants;
  constants.volume_m3 = 1e-6 * options.volume_mL;
  constants.supply_Pa = 1e3 * options.supply_kPa;
  constants.plunger_damping_N_s_m = options.plunger_damping_N_s_m;
  constants.spool_damping_N_s_m = options.spool_damping_N_s_m;
  constants.rest_screw_m = 1e-3 * options.rest_screw_mm;
  const Fitted& up = rising.models.back();
  const Fitted& down = falling.models.back();
  const valve::InternalParameters is = valve::internal_parameters(up.model, down.model, constants);
  valve::InternalParameters error =
      valve::internal_parameter_errors(up.model, up.error, down.model, down.error, constants);
  const std::string too_fast = unresolved(up, down);
  const auto row = [&](const char* key, const char* name, const char* unit, double per_unit,
                       double valve::InternalParameters::*field) {
    const double spread = std::isnan(error.*field) ? std::numeric_limits<double>::infinity() : error.*field;
    return Figure{key, name, unit, per_unit, is.*field, spread, is.*field > 0.0 ? too_fast : "no such valve"};
  };
  return {
      row("diaphragm_area_m2", "diaphragm area A_d", "cm2", 1e4,
          &valve::InternalParameters::diaphragm_area_m2),
      row("plunger_mass_kg", "plunger mass m_e", "g", 1e3, &valve::InternalParameters::plunger_mass_kg),
      row("spool_mass_kg", "spool mass m_c", "g", 1e3, &valve::InternalParameters::spool_mass_kg),
      row("plunger_spring_N_m", "plunger spring k_me", "N/m", 1.0,
          &valve::InternalParameters::plunger_spring_N_m),
      row("spool_spring_N_m", "spool spring k_mc", "N/m", 1.0, &valve::InternalParameters::spool_spring_N_m),
      row("inlet_width_m", "inlet width k_1", "mm", 1e3, &valve::InternalParameters::inlet_width_m),
      row("exhaust_width_m", "exhaust width k_2", "mm", 1e3, &valve::InternalParameters::exhaust_width_m)};
}

struct Answer {
  Named log;
  std::optional<Named> other{};
  std::vector<Side> sides{};
  std::vector<std::string> missing{};  ///< directions that the log does not have, and why
  std::optional<Whole> whole{};
  Figures inside{};

  const Named& judged() const { return other ? *other : log; }
};

Answer identified(const Options& options) {
  Answer answer{.log = read(options.log, options)};
  if (!options.held_out.empty()) answer.other = read(options.held_out, options);
  const valve::PressureRange range = options.range();
  for (const Direction direction : {Direction::kRising, Direction::kFalling}) {
    try {
      answer.sides.push_back(side_of(answer.log, answer.other, direction, range));
    } catch (const identify::CannotIdentify& why) {
      answer.missing.emplace_back(why.what());
    }
  }
  if (answer.sides.empty()) {
    throw identify::CannotIdentify(fmt::format("{}: {}; {}; gauge, see --pressure-low and --pressure-high",
                                               answer.log.name, answer.missing[0], answer.missing[1]));
  }
  for (Side& side : answer.sides) {
    fit(side, answer.log, options);
    score_held_out(side, answer.judged());
  }
  if (answer.missing.empty()) {
    answer.whole = run_whole(answer.sides[0], answer.sides[1], answer.log, answer.judged(), range);
    if (options.internal) answer.inside = inside(answer.sides[0], answer.sides[1], options);
  } else if (options.internal) {
    throw identify::CannotIdentify(
        fmt::format("{}: {}; --internal needs both branches", answer.log.name, answer.missing.front()));
  }
  return answer;
}

double seconds(const Branch& branch) {
  return branch.sample_s * static_cast<double>(branch.screw_m.size());
}

void print(const Options& options, const Answer& answer) {
  const Output& output = options.output;
  const valve::PressureRange range = options.range();
  output.print("{}: {} positions held, {:.4g} s at {:.4g} Hz; fitted from {:.1f} to {:.1f} kPa\n",
               answer.log.name, answer.log.positions,
               answer.log.recording.sample_s * static_cast<double>(answer.log.recording.screw_m.size()),
               1.0 / answer.log.recording.sample_s, 1e-3 * (range.low_Pa + options.ambient_Pa()),
               1e-3 * (range.high_Pa + options.ambient_Pa()));
  for (const Side& side : answer.sides) {
    for (const Fitted& of : side.models) {
      output.print("{}, {}: fit {:.2f} % of {:.3g} s, held out {:.2f} % of {:.3g} s, in free run\n",
                   side.name(), of.method, of.fit_percent, seconds(side.fitted), of.held_out_percent,
                   seconds(side.held_out));
      print(output, figures_of(of), 2);
    }
  }
  for (const std::string& why : answer.missing) output.print("no {}\n", why);
  if (answer.whole) {
    output.print("rising, falling, at rest within a dead band of {:.3f} mm: fit {:.2f} % of {}\n",
                 1e3 * answer.whole->dead_band.width_m, answer.whole->fit_percent, answer.judged().name);
    output.print("  the first {:.3f} mm of the screw move nothing\n",
                 1e3 * answer.whole->dead_band.rising_start_m);
  }
  if (!answer.inside.empty()) {
    output.print("inside, if damping and volume are as told\n");
    print(output, answer.inside, 2);
  }
}

Json json_of(const Options& options, const Answer& answer) {
  const valve::PressureRange range = options.range();
  Json json{{"schema", "plenum-regulator/1"},
            {"file", answer.log.name},
            {"held_out_file", answer.other ? Json(answer.other->name) : Json(nullptr)},
            {"sample_s", answer.log.recording.sample_s},
            {"positions", answer.log.positions},
            {"pressure_low_Pa", range.low_Pa + options.ambient_Pa()},
            {"pressure_high_Pa", range.high_Pa + options.ambient_Pa()}};
  for (const Side& side : answer.sides) {
    Json& branch = json[side.name()];
    branch = {{"fitted_s", seconds(side.fitted)},
              {"held_out_s", seconds(side.held_out)},
              {"rest_screw_m", side.fitted.mean_screw_m},
              {"rest_pressure_Pa", side.fitted.mean_pressure_Pa + options.ambient_Pa()}};
    for (const Fitted& of : side.models) {
      branch[of.method] = {{"fit_percent", number(of.fit_percent)},
                           {"held_out_fit_percent", number(of.held_out_percent)},
                           {"stable", valve::stable(of.model)},
                           {"parameters", to_json(figures_of(of))}};
    }
  }
  json["missing"] = answer.missing;
  if (answer.whole) {
    json["three_conditions"] = {{"dead_band_m", answer.whole->dead_band.width_m},
                                {"idle_m", answer.whole->dead_band.rising_start_m},
                                {"fit_percent", number(answer.whole->fit_percent)},
                                {"held_out", answer.other.has_value()}};
  }
  if (!answer.inside.empty()) json["internal"] = to_json(answer.inside);
  return json;
}

std::vector<double> absolute_kPa(std::vector<double> pressure_Pa, double ambient_Pa, double mean_Pa = 0.0) {
  for (double& p : pressure_Pa) p = 1e-3 * (p + mean_Pa + ambient_Pa);
  return pressure_Pa;
}

report::XyChart steps_chart(const Named& log, const Options& options) {
  report::Curve up{.name = "turned up", .x = {}, .y = {}};
  report::Curve down{.name = "turned down", .x = {}, .y = {}};
  const std::vector<valve::Plateau> all = valve::plateaus(log.recording);
  for (std::size_t i = 0; i < all.size(); ++i) {
    report::Curve& of = i == 0 || all[i].screw_m > all[i - 1].screw_m ? up : down;
    of.x.push_back(1e3 * all[i].screw_m);
    of.y.push_back(1e-3 * (all[i].settled_Pa + options.ambient_Pa()));
  }
  const valve::PressureRange range = options.range();
  return {.title = "Settled pressure over the screw",
          .caption = "Each position once the pressure has settled; the models are fitted between the lines.",
          .x = {"Screw", "mm"},
          .y = {"Pressure", "kPa"},
          .curves = {std::move(up), std::move(down)},
          .marks = {{report::Mark::On::kY, 1e-3 * (range.low_Pa + options.ambient_Pa()), "lowest"},
                    {report::Mark::On::kY, 1e-3 * (range.high_Pa + options.ambient_Pa()), "highest"}}};
}

report::Page page_of(const Options& options, const Answer& answer) {
  report::Page page("Pressure regulator valve, from a staircase of its screw");
  page.lead(
      "Third-order models of a rising and of a falling pressure, by least squares of the next sample (ls) "
      "and by the "
      "swarm that seeks the best free run (pso), scored in free run on what neither has seen. Standard "
      "errors "
      "take errors as white; those of ls do not hold the bias that noise gives it.");
  std::vector<report::Tile> tiles;
  for (const Side& side : answer.sides) {
    tiles.push_back({fmt::format("Held-out fit, {}", side.name()),
                     side.models.back().held_out_percent,
                     "%",
                     {},
                     side.models.back().method});
  }
  if (answer.whole) tiles.push_back({"Dead band", 1e3 * answer.whole->dead_band.width_m, "mm"});
  page.tiles(std::move(tiles));

  const double ambient_Pa = options.ambient_Pa();
  const Named& judged = answer.judged();
  report::Section& steps = page.section(judged.name);
  const std::string group = "log";
  report::LineChart pressure{
      .title = "Pressure",
      .y = {"Pressure", "kPa"},
      .curves = {{"measured", times_s(judged.recording.pressure_Pa.size(), judged.recording.sample_s),
                  absolute_kPa(judged.recording.pressure_Pa, ambient_Pa), report::Stroke::kSolid,
                  report::Ink::kNeutral}},
      .group = group};
  if (answer.whole) {
    pressure.caption = fmt::format(
        "Rising, falling or at rest within the dead band: fit {:.2f} % of what lies in the "
        "range.",
        answer.whole->fit_percent);
    pressure.curves.push_back(
        {"three conditions",
         times_s(answer.whole->gauge_Pa.size(), judged.recording.sample_s, answer.whole->first),
         absolute_kPa(answer.whole->gauge_Pa, ambient_Pa)});
  }
  std::vector<double> screw_mm = judged.recording.screw_m;
  for (double& x : screw_mm) x *= 1e3;
  steps.row({std::move(pressure),
             report::LineChart{.title = "Screw",
                               .y = {"Screw", "mm"},
                               .curves = {{"screw", times_s(screw_mm.size(), judged.recording.sample_s),
                                           screw_mm, report::Stroke::kSteps}},
                               .group = group}});
  steps.chart(steps_chart(answer.log, options));
  for (const std::string& why : answer.missing) steps.note("No " + why + ".");

  for (const Side& side : answer.sides) {
    report::Section& section = page.section(fmt::format("{} branch", side.name()));
    const std::vector<double> time_s =
        times_s(side.held_out.screw_m.size(), side.held_out.sample_s, side.held_out.first);
    const double mean_Pa = side.held_out.mean_pressure_Pa;
    report::LineChart held{
        .title = "Held out",
        .caption = "Free runs from the first three samples.",
        .y = {"Pressure", "kPa"},
        .curves = {{"measured", time_s, absolute_kPa(side.held_out.pressure_Pa, ambient_Pa, mean_Pa),
                    report::Stroke::kSolid, report::Ink::kNeutral}},
        .group = side.name()};
    report::LineChart errors{
        .title = "Error", .caption = "Free run minus measured.", .y = {"Error", "kPa"}, .group = side.name()};
    for (const Fitted& of : side.models) {
      held.curves.push_back({of.method, time_s, absolute_kPa(of.held_out_Pa, ambient_Pa, mean_Pa)});
      std::vector<double> error_kPa = of.held_out_Pa;
      for (std::size_t k = 0; k < error_kPa.size(); ++k)
        error_kPa[k] = 1e-3 * (error_kPa[k] - side.held_out.pressure_Pa[k]);
      errors.curves.push_back({of.method, time_s, std::move(error_kPa)});
    }
    section.row({std::move(held), std::move(errors)});
    for (const Fitted& of : side.models) {
      section.table(table_of(figures_of(of), fmt::format("{}: fit {:.2f} %, held out {:.2f} %", of.method,
                                                         of.fit_percent, of.held_out_percent)));
    }
  }
  if (!answer.inside.empty()) {
    page.section("Inside")
        .paragraph(
            "What the coefficients say of masses, springs and ports, damping and volume taken as told. "
            "Masses and springs rest on poles of milliseconds: where noise hides these, so are they.")
        .table(table_of(answer.inside, "Internal parameters"));
  }
  return page;
}

int run(const Options& options) {
  const valve::PressureRange range = options.range();
  if (!(range.low_Pa < range.high_Pa)) {
    throw std::invalid_argument(fmt::format(
        "fitted from {:.4g} to {:.4g} kPa, expected --pressure-low below "
        "--pressure-high, and without them a supply above 3.59 times the ambient",
        1e-3 * (range.low_Pa + options.ambient_Pa()), 1e-3 * (range.high_Pa + options.ambient_Pa())));
  }
  const Answer answer = identified(options);
  print(options, answer);
  write_report(options.output, options.report, [&] { return page_of(options, answer); });
  options.output.finish(json_of(options, answer));
  return kDone;
}

}  // namespace

Command add_regulator(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("regulator", "Fit a pressure regulator valve to a staircase of its screw, up and down");
  arguments
      .option("LOG", options->log,
              "Recording with the columns time_s, screw_m (as commanded, each position held until the "
              "pressure has "
              "settled) and pressure_Pa (absolute)")
      .type_name("LOG.csv")
      .required();
  arguments
      .option(
          "--heldout", options->held_out,
          "Another staircase to score the free runs on (default: the last 40 % of each branch is held out)")
      .type_name("HELD.csv");
  arguments
      .option("--method", options->method,
              "ls: least squares of the next sample; pso: particle swarm of the free run; both")
      .one_of({"ls", "pso", "both"})
      .show_default();
  arguments.option("--supply", options->supply_kPa, "Pressure of the supply, absolute [kPa]")
      .within(1.0, 1e5)
      .show_default();
  arguments.option("--ambient", options->ambient_kPa, "Pressure of the surroundings, absolute [kPa]")
      .within(1.0, 1e3)
      .show_default();
  arguments.option(
      "--pressure-low", options->low_kPa,
      "Fit positions that settle above, absolute [kPa] (default: ambient/0.528, where the exhaust chokes)");
  arguments.option(
      "--pressure-high", options->high_kPa,
      "Fit positions that settle below, absolute [kPa] (default: 0.528 supply, where the inlet chokes)");
  arguments.option("--seed", options->seed, "Of the swarm").show_default();
  arguments.flag("--internal", options->internal,
                 "Masses, springs, diaphragm and ports too, from the four that follow (default: none)");
  arguments.option("--volume", options->volume_mL, "With --internal: regulated volume [mL]")
      .within(1e-3, 1e9)
      .show_default();
  arguments
      .option("--plunger-damping", options->plunger_damping_N_s_m, "With --internal: of the plunger [N s/m]")
      .within(1e-6, 1e9)
      .show_default();
  arguments.option("--spool-damping", options->spool_damping_N_s_m, "With --internal: of the spool [N s/m]")
      .within(0.0, 1e9)
      .show_default();
  arguments
      .option("--rest-screw", options->rest_screw_mm,
              "With --internal: position of the screw about which the falling branch was fitted [mm]")
      .within(1e-6, 1e3)
      .show_default();
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum regulator --supply 800 staircase.csv --report regulator.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
