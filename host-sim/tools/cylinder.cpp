// A servo cylinder on a 5/3 valve, from recordings of its command and position: valve, friction and mass.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/identify/network/narx.hpp"
#include "host-sim/identify/servo/cylinder_fit.hpp"
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

namespace servo = identify::servo;
using servo::ServoRecord;
using servo::ServoRig;

constexpr double kBeyond = 0.02;  // of the stroke: a transducer's zero and scale
constexpr std::array<const char*, 2> kPressures{"pressure_1_Pa", "pressure_2_Pa"};
constexpr std::size_t kDrawn = 200;  // points of a curve

/// A figure of servo::kFittedNames, as the command line calls it, and the option with its start.
struct Name {
  const char* held;
  const char* option;
};
constexpr std::array<Name, servo::kFittedNames.size()> kNames{{{"inlet-area", "--area"},
                                                               {"exhaust-area", "--area"},
                                                               {"null", "--null"},
                                                               {"coulomb", "--coulomb"},
                                                               {"stribeck", "--stribeck"},
                                                               {"viscous", "--viscous"},
                                                               {"mass", "--mass"}}};

struct Options {
  std::string log;
  std::vector<std::string> held_out;
  double bore_mm = 0.0;
  double rod_mm = 0.0;
  double stroke_mm = 0.0;
  double dead_volume_mL = 20.0;
  double supply_kPa = 700.0;
  double ambient_kPa = 101.325;
  double exponent = 1.4;
  std::array<std::optional<double>, 2> start_kPa;
  double dead_band_V = 0.16;
  double leak_mm2 = 0.03;
  std::optional<double> spool_Hz;
  double spool_damping = 0.7;
  double area_mm2_V = 1.5;
  double null_V = 5.0;
  double mass_kg = 5.0;
  std::optional<double> coulomb_N;
  std::optional<double> stribeck_N;
  double stribeck_mm_s = 20.0;
  std::optional<double> viscous_N_s_m;
  std::vector<std::string> held;
  std::string report;
  Output output;

  /// What is known before the fit, and where it starts; the state at the start is that of a recording.
  ServoRig guess() const {
    ServoRig rig;
    auto& valve = rig.valve;
    valve.open_above_V = null_V + 0.5 * dead_band_V;
    valve.exhaust_below_V = null_V - 0.5 * dead_band_V;
    valve.inlet_area_per_V_m2 = valve.exhaust_area_per_V_m2 = 1e-6 * area_mm2_V;
    valve.inlet_leak_m2 = valve.exhaust_leak_m2 = 1e-6 * leak_mm2;
    auto& cylinder = rig.cylinder;
    cylinder.supply_Pa = 1e3 * supply_kPa;
    cylinder.ambient_Pa = 1e3 * ambient_kPa;
    cylinder.piston_area_1_m2 = 0.25e-6 * std::numbers::pi * bore_mm * bore_mm;
    cylinder.piston_area_2_m2 = 0.25e-6 * std::numbers::pi * (bore_mm * bore_mm - rod_mm * rod_mm);
    cylinder.stroke_m = 1e-3 * stroke_mm;
    cylinder.dead_volume_1_m3 = cylinder.dead_volume_2_m3 = 1e-6 * dead_volume_mL;
    cylinder.moving_mass_kg = mass_kg;
    // of a cylinder's usual seals: 1/20 of the thrust, and half of that more to break away
    const double thrust_N = cylinder.piston_area_1_m2 * (cylinder.supply_Pa - cylinder.ambient_Pa);
    const double seals_N = coulomb_N.value_or(0.05 * thrust_N);
    cylinder.friction = {seals_N, stribeck_N.value_or(0.5 * seals_N), 1e-3 * stribeck_mm_s,
                         viscous_N_s_m.value_or(0.16 * thrust_N)};
    cylinder.law = plant::servo::Polytropic{exponent};
    if (spool_Hz) cylinder.spool = plant::SpoolConfig{*spool_Hz, spool_damping};
    return rig;
  }

  servo::PerFigure held_figures() const {
    servo::PerFigure all{};
    for (std::size_t i = 0; i < all.size(); ++i)
      all[i] = std::find(held.begin(), held.end(), kNames[i].held) != held.end();
    return all;
  }
};

/// One recording, and the free run of the fitted servo along it.
struct Run {
  std::string name;
  ServoRecord record{};
  std::array<std::vector<double>, 2> pressures_Pa{};  ///< measured; empty where they were not
  std::array<double, 2> start_Pa{};
  std::size_t held_out_from = 0;  ///< row; what is before was fitted
  servo::ServoRun predicted{};
  double rms_m = 0.0;  ///< of the held-out rows
  double fit_percent = 0.0;
  std::array<std::optional<double>, 2> pressure_rms_Pa{};
};

Run read_run(const std::string& file, const Options& options, double held_out) {
  const trace::Recording log = read_bench("cylinder", file, {"time_s", "command_V", "position_m"},
                                          {kPressures.begin(), kPressures.end()});
  const double stroke_m = 1e-3 * options.stroke_mm;
  require_between(
      log, "position_m", -kBeyond * stroke_m, (1.0 + kBeyond) * stroke_m,
      fmt::format("m from the end where chamber 1 is smallest, 0 to the stroke of {:g}", stroke_m));
  require_between(log, "command_V", 0.0, 10.0, "a command of a 5/3 valve, 0 to 10 V");
  Run run{.name = log.name,
          .record = {.period_s = trace::period_s(log),
                     .commands_V = log["command_V"],
                     .positions_m = log["position_m"]}};
  for (double& x : run.record.positions_m) x -= 0.5 * stroke_m;  // (20) counts from the middle
  for (std::size_t side = 0; side < kPressures.size(); ++side) {
    if (log.columns.count(kPressures[side]) > 0) {
      require_absolute_pressure(log, kPressures[side], 1e3 * options.ambient_kPa);
      run.pressures_Pa[side] = log[kPressures[side]];
      run.start_Pa[side] = run.pressures_Pa[side].front();
    }
    if (options.start_kPa[side]) run.start_Pa[side] = 1e3 * *options.start_kPa[side];
    if (run.start_Pa[side] > 0.0) continue;
    throw trace::InputError(
        fmt::format("{}: column '{}' is missing, expected it, or --start-pressure-{}: the run starts at the "
                    "chamber's pressure",
                    run.name, kPressures[side], side + 1));
  }
  run.held_out_from = rows_before(log.rows, held_out);
  return run;
}

/// `rig` at the start of a run: at rest.
ServoRig at_start(ServoRig rig, const Run& run) {
  auto& cylinder = rig.cylinder;
  const double end_m = 0.5 * cylinder.stroke_m;
  cylinder.initial_position_m = std::clamp(run.record.positions_m.front(), -end_m, end_m);
  cylinder.initial_pressure_1_Pa = run.start_Pa[0];
  cylinder.initial_pressure_2_Pa = run.start_Pa[1];
  cylinder.initial_command_V = run.record.commands_V.front();
  return rig;
}

ServoRecord fitted_part(const Run& run) {
  const auto rows = static_cast<std::ptrdiff_t>(run.held_out_from);
  const ServoRecord& all = run.record;
  return {.period_s = all.period_s,
          .commands_V = {all.commands_V.begin(), all.commands_V.begin() + rows},
          .positions_m = {all.positions_m.begin(), all.positions_m.begin() + rows}};
}

double rms(const std::vector<double>& predicted, const std::vector<double>& measured, std::size_t from) {
  double squares = 0.0;
  for (std::size_t k = from; k < measured.size(); ++k) squares += std::pow(predicted[k] - measured[k], 2);
  return std::sqrt(squares / static_cast<double>(measured.size() - from));
}

void score(Run& run, const ServoRig& rig) {
  run.predicted = servo::free_run(at_start(rig, run), run.record);
  const auto held_out = [&](const std::vector<double>& column) {
    return std::span<const double>(column).subspan(run.held_out_from);
  };
  run.rms_m = rms(run.predicted.positions_m, run.record.positions_m, run.held_out_from);
  run.fit_percent =
      identify::network::fit_percent(held_out(run.record.positions_m), held_out(run.predicted.positions_m));
  const std::array predicted{&run.predicted.pressures_1_Pa, &run.predicted.pressures_2_Pa};
  for (std::size_t side = 0; side < predicted.size(); ++side) {
    if (!run.pressures_Pa[side].empty())
      run.pressure_rms_Pa[side] = rms(*predicted[side], run.pressures_Pa[side], run.held_out_from);
  }
}

struct Answer {
  Run fitted;
  std::size_t rows = 0;  ///< that were fitted
  servo::ServoFit fit{};
  double unbalanced_N = 0.0;  ///< what pushes the piston at the start, at rest
  std::vector<Run> runs{};    ///< those that are scored
};

Answer identified(const Options& options) {
  Answer answer{.fitted = read_run(options.log, options, options.held_out.empty() ? kHeldOut : 0.0)};
  const ServoRecord part = fitted_part(answer.fitted);
  answer.rows = part.positions_m.size();
  const ServoRig guess = at_start(options.guess(), answer.fitted);
  told_of(answer.fitted.name, [&] {
    Progress progress("fitting the servo");
    answer.fit = servo::fit_servo(guess, part, options.held_figures(), std::ref(progress));
  });
  answer.unbalanced_N =
      plant::servo::driving_force_N(guess.cylinder, plant::servo::initial_state(guess.cylinder));
  if (options.held_out.empty()) {
    answer.runs.push_back(answer.fitted);
  } else {
    for (const std::string& file : options.held_out) {
      answer.runs.push_back(read_run(file, options, 1.0));
    }
  }
  for (Run& run : answer.runs) score(run, answer.fit.rig);
  return answer;
}

Figures figures_of(const Options& options, const servo::ServoFit& fit) {
  const auto& valve = fit.rig.valve;
  const auto& cylinder = fit.rig.cylinder;
  Figures figures{
      {"inlet_area_m2_V", "inlet area for each volt", "mm2/V", 1e6, valve.inlet_area_per_V_m2},
      {"exhaust_area_m2_V", "exhaust area for each volt", "mm2/V", 1e6, valve.exhaust_area_per_V_m2},
      {"null_V", "null", "V", 1.0, 0.5 * (valve.open_above_V + valve.exhaust_below_V)},
      {"coulomb_N", "Coulomb friction F_c", "N", 1.0, cylinder.friction.coulomb_N},
      {"stribeck_N", "Stribeck friction F_s", "N", 1.0, cylinder.friction.stribeck_N},
      {"viscous_N_s_m", "viscous friction F_v", "N s/m", 1.0, cylinder.friction.viscous_N_s_m},
      {"moving_mass_kg", "moving mass", "kg", 1.0, cylinder.moving_mass_kg}};
  const servo::PerFigure held = options.held_figures();
  for (std::size_t i = 0; i < figures.size(); ++i) {
    Figure& figure = figures[i];
    const bool absolute = figure.key == "null_V";
    if (held[i]) {
      figure.why_not = "held";
      continue;
    }
    figure.standard_error = fit.error[i] * (absolute ? 1.0 : figure.value);
    if (!fit.at_bound[i]) continue;
    figure.why_not = absolute
                         ? fmt::format("at its bound: {:g} V from {}", servo::kWidestNull_V, kNames[i].option)
                         : fmt::format("at its bound: {:g} times or a {:g}th of where {} starts it",
                                       servo::kWidest, servo::kWidest, kNames[i].option);
  }
  return figures;
}

std::string pressure_text(const Run& run) {
  std::string text;
  for (std::size_t side = 0; side < run.pressure_rms_Pa.size(); ++side) {
    if (run.pressure_rms_Pa[side])
      text += fmt::format(", pressure {} {:.3g} kPa", side + 1, 1e-3 * *run.pressure_rms_Pa[side]);
  }
  return text;
}

double held_out_s(const Run& run) {
  return run.record.period_s * static_cast<double>(run.held_out_from);
}

void print(const Options& options, const Answer& answer) {
  const Output& output = options.output;
  output.print(
      "{}: {} rows fitted, {:.3g} mm RMS in free run; at the start {:.3g} N push the piston, at rest\n",
      answer.fitted.name, answer.rows, 1e3 * answer.fit.rms_m, answer.unbalanced_N);
  print(output, figures_of(options, answer.fit), 2);
  for (const Run& run : answer.runs) {
    output.print("{}: held out from {:.3g} s, free run errs by {:.3g} mm RMS (fit {:.3g} %){}\n", run.name,
                 held_out_s(run), 1e3 * run.rms_m, run.fit_percent, pressure_text(run));
  }
}

Json json_of(const Options& options, const Answer& answer) {
  Json json{{"schema", "plenum-cylinder/1"},
            {"file", answer.fitted.name},
            {"rows", answer.rows},
            {"rms_m", answer.fit.rms_m},
            {"start_force_N", answer.unbalanced_N},
            {"parameters", to_json(figures_of(options, answer.fit))},
            {"runs", Json::array()}};
  for (const Run& run : answer.runs) {
    json["runs"].push_back({{"file", run.name},
                            {"held_out_from_s", held_out_s(run)},
                            {"rms_m", number(run.rms_m)},
                            {"fit_percent", number(run.fit_percent)},
                            {"pressure_1_rms_Pa", number(run.pressure_rms_Pa[0])},
                            {"pressure_2_rms_Pa", number(run.pressure_rms_Pa[1])}});
  }
  return json;
}

report::LineChart against_time(const Run& run, const char* title, report::Axis axis) {
  report::LineChart chart{.title = title, .y = std::move(axis), .group = run.name};
  if (run.held_out_from > 0) chart.marks.push_back(held_out_from(held_out_s(run)));
  return chart;
}

report::XyChart friction_chart(const ServoRig& guess, const ServoRig& found, double fastest_m_s) {
  report::XyChart chart{.title = "Friction",
                        .caption = "F_c + F_s exp(-v/v_s) + F_v v",
                        .x = {"Velocity", "mm/s"},
                        .y = {"Friction", "N"}};
  for (const auto& [name, rig] : {std::pair{"fitted", &found}, std::pair{"start of the fit", &guess}}) {
    report::Curve curve{.name = name, .x = {}, .y = {}};
    if (rig == &guess) curve.stroke = report::Stroke::kDashed;
    for (std::size_t i = 0; i <= kDrawn; ++i) {
      const double v = fastest_m_s * static_cast<double>(i) / static_cast<double>(kDrawn);
      curve.x.push_back(1e3 * v);
      curve.y.push_back(plant::servo::sliding_friction_N(rig->cylinder.friction, 1.0, v));
    }
    chart.curves.push_back(std::move(curve));
  }
  return chart;
}

double fastest_m_s(const Run& run) {
  double fastest = 0.0;
  const std::vector<double>& x = run.predicted.positions_m;
  for (std::size_t k = 1; k < x.size(); ++k)
    fastest = std::max(fastest, std::abs(x[k] - x[k - 1]) / run.record.period_s);
  return fastest;
}

report::Page page_of(const Options& options, const Answer& answer) {
  report::Page page("Servo cylinder, from its command and position");
  page.lead(
      "One 5/3 valve, two chambers and a piston with stick and slip, run freely from rest: the valve's areas "
      "and null, the friction and the moving mass are those whose run comes closest to the recording.");
  const Run& first = answer.runs.front();
  page.tiles({{"Held out in free run", 1e3 * first.rms_m, "mm RMS", {}, first.name},
              {"Fit, held out", first.fit_percent, "%"},
              {"Moving mass", answer.fit.rig.cylinder.moving_mass_kg, "kg"},
              {"To break away", answer.fit.rig.cylinder.friction.breakaway_N(), "N"}});
  page.section("Figures")
      .table(table_of(figures_of(options, answer.fit),
                      fmt::format("{} rows, {:.3g} mm RMS in free run", answer.rows, 1e3 * answer.fit.rms_m)))
      .row({friction_chart(options.guess(), answer.fit.rig, fastest_m_s(first))});
  for (const Run& run : answer.runs) {
    const std::vector<double> t = times_s(run.record.positions_m.size(), run.record.period_s);
    report::LineChart position = against_time(run, "Position", {"Position from mid-stroke", "mm"});
    position.caption =
        fmt::format("Held out: {:.3g} mm RMS, fit {:.3g} %.", 1e3 * run.rms_m, run.fit_percent);
    position.curves = {
        {"measured", t, scaled(run.record.positions_m, 1e3), report::Stroke::kSolid, report::Ink::kNeutral},
        {"free run", t, scaled(run.predicted.positions_m, 1e3)}};
    report::LineChart error = against_time(run, "Error of the free run", {"Predicted less measured", "mm"});
    std::vector<double> off = run.predicted.positions_m;
    for (std::size_t k = 0; k < off.size(); ++k) off[k] -= run.record.positions_m[k];
    error.curves = {{"error", t, scaled(std::move(off), 1e3)}};
    report::LineChart command = against_time(run, "Command", {"Command", "V"});
    command.curves = {{"command", t, run.record.commands_V, report::Stroke::kSteps}};
    report::LineChart pressure = against_time(run, "Pressures", {"Pressure", "kPa"});
    const std::array predicted{&run.predicted.pressures_1_Pa, &run.predicted.pressures_2_Pa};
    for (std::size_t side = 0; side < predicted.size(); ++side) {
      if (!run.pressures_Pa[side].empty()) {
        pressure.curves.push_back({fmt::format("measured, {}", side + 1), t,
                                   scaled(run.pressures_Pa[side], 1e-3), report::Stroke::kSolid,
                                   report::Ink::kNeutral});
      }
      pressure.curves.push_back({fmt::format("free run, {}", side + 1), t, scaled(*predicted[side], 1e-3)});
    }
    page.section(run.name)
        .chart(std::move(position))
        .chart(std::move(error))
        .row({std::move(command), std::move(pressure)});
  }
  return page;
}

int run(const Options& options) {
  if (options.rod_mm >= options.bore_mm) {
    throw std::invalid_argument(
        fmt::format("--rod {:g}, expected less than --bore {:g} mm", options.rod_mm, options.bore_mm));
  }
  require_order("--ambient", options.ambient_kPa, "--supply", options.supply_kPa, "kPa");
  const Answer answer = identified(options);
  print(options, answer);
  write_report(options.output, options.report, [&] { return page_of(options, answer); });
  options.output.finish(json_of(options, answer));
  return kDone;
}

void declare_data_sheet(Arguments& arguments, Options& options) {
  const char* const group = "Of the data sheet, held";
  arguments.option("--bore", options.bore_mm, "Of the cylinder [mm]")
      .within(0.1, 1e4)
      .required()
      .group(group);
  arguments.option("--rod", options.rod_mm, "Through chamber 2 [mm]; 0: none")
      .within(0.0, 1e4)
      .show_default()
      .group(group);
  arguments.option("--stroke", options.stroke_mm, "[mm]").within(1.0, 1e4).required().group(group);
  arguments
      .option("--dead-volume", options.dead_volume_mL, "Of either chamber at its end, with its hose [mL]")
      .within(0.01, 1e5)
      .show_default()
      .group(group);
  arguments.option("--supply", options.supply_kPa, "Absolute [kPa]")
      .within(1.0, 1e5)
      .show_default()
      .group(group);
  arguments.option("--ambient", options.ambient_kPa, "Absolute [kPa]")
      .within(1.0, 1e4)
      .show_default()
      .group(group);
  arguments
      .option("--exponent", options.exponent,
              "Of the polytrope of both chambers: 1 isothermal, 1.4 adiabatic")
      .within(1.0, 1.4)
      .show_default()
      .group(group);
  arguments.option("--dead-band", options.dead_band_V, "Between the commands that open inlet and exhaust [V]")
      .within(0.0, 5.0)
      .show_default()
      .group(group);
  arguments.option("--leak", options.leak_mm2, "Of a shut port [mm2], of a thin plate")
      .within(0.0, 1e3)
      .show_default()
      .group(group);
  arguments
      .option("--spool", options.spool_Hz, "Natural frequency of the spool [Hz] (default: it acts at once)")
      .within(1.0, 1e4)
      .group(group);
  arguments.option("--spool-damping", options.spool_damping, "Its damping ratio")
      .within(0.01, 10.0)
      .show_default()
      .group(group);
  arguments.option("--stribeck-velocity", options.stribeck_mm_s, "v_s of (23) [mm/s]")
      .within(1e-3, 1e4)
      .show_default()
      .group(group);
  for (std::size_t side = 0; side < kPressures.size(); ++side) {
    arguments
        .option(
            fmt::format("--start-pressure-{}", side + 1), options.start_kPa[side],
            fmt::format(
                "Of chamber {} at the start of each recording, absolute [kPa] (default: the first row's {})",
                side + 1, kPressures[side]))
        .within(1.0, 1e5)
        .group(group);
  }
}

void declare_start(Arguments& arguments, Options& options) {
  const char* const group =
      "Where the fit starts, and looks for up to 4 times as much and as little (null: 0.2 V)";
  arguments.option("--area", options.area_mm2_V, "Of an opening port, for each volt [mm2/V], of a thin plate")
      .within(1e-4, 1e4)
      .show_default()
      .group(group);
  arguments.option("--null", options.null_V, "Command at which the valve is shut [V]")
      .within(0.0, 10.0)
      .show_default()
      .group(group);
  arguments.option("--mass", options.mass_kg, "Piston, rod and load [kg]")
      .within(1e-3, 1e5)
      .show_default()
      .group(group);
  arguments.option("--coulomb", options.coulomb_N, "F_c [N] (default: 5 % of the supply's thrust)")
      .within(1e-3, 1e6)
      .group(group);
  arguments.option("--stribeck", options.stribeck_N, "F_s [N] (default: half of F_c)")
      .within(1e-3, 1e6)
      .group(group);
  arguments.option("--viscous", options.viscous_N_s_m, "F_v [N s/m] (default: 16 % of the thrust at 1 m/s)")
      .within(1e-3, 1e6)
      .group(group);
  std::vector<std::string> names;
  names.reserve(kNames.size());
  for (const Name& name : kNames) names.emplace_back(name.held);
  arguments.option("--hold", options.held, "Known: not fitted (default: none)")
      .one_of(names)
      .one_at_a_time()
      .group(group);
}

}  // namespace

Command add_cylinder(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "cylinder",
      "Fit a servo cylinder's valve, friction and mass to a recording of its command and position");
  arguments
      .option("LOG", options->log,
              "A recording from rest, with the columns time_s, command_V (of the 5/3 valve; above the null "
              "it fills chamber 1) and position_m (from the end where chamber 1 is smallest), and, where "
              "they are measured, pressure_1_Pa and pressure_2_Pa (absolute)")
      .type_name("LOG.csv")
      .required();
  arguments
      .option("--heldout", options->held_out,
              "Recordings from rest to score the free run on (default: the last 40 % of LOG is held out)")
      .type_name("RUN.csv");
  declare_data_sheet(arguments, *options);
  declare_start(arguments, *options);
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(
      example("  plenum cylinder moves.csv --bore 32 --rod 12 --stroke 200 --supply 700 --heldout others.csv "
              "--report servo.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
