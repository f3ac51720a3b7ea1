// Friction of a cylinder from recordings of a bench that pulls its piston to and fro at a regulated pressure.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/servo/friction_fit.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/tools/arguments.hpp"
#include "host-sim/tools/bench_input.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/figures.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"

namespace plenum::host::tools {
namespace {

namespace servo = identify::servo;
using servo::SlidingRow;

constexpr const char* kZillen = "zillen";
constexpr double kLongestStroke_m = 10.0;  // more is another unit

struct Options {
  std::vector<std::string> logs;
  std::string format = "csv";
  double ambient_kPa = 101.325;
  std::optional<double> bore_mm;
  bool viscous = false;
  std::optional<double> stribeck_mm_s;
  double slowest_mm_s = 2.0;
  double ends_percent = 10.0;
  std::string report;
  Output output;

  servo::FrictionTerms terms() const {
    servo::FrictionTerms terms{.viscous = viscous};
    if (stribeck_mm_s) terms.stribeck_velocity_m_s = 1e-3 * *stribeck_mm_s;
    if (bore_mm) terms.area_m2 = 0.25e-6 * std::numbers::pi * *bore_mm * *bore_mm;
    return terms;
  }
};

/// One recording, and what of it slides.
struct Pulled {
  std::string name;
  double pressure_Pa = 0.0;  ///< gauge, the mean of the sliding rows
  std::vector<SlidingRow> fitted{};
  std::vector<SlidingRow> held_out{};
  double rms_N = 0.0;           ///< of the held-out rows
  double frictionless_N = 0.0;  ///< theirs, of pressure and force zero alone
};

std::vector<double> scaled_column(const trace::Recording& log, std::string_view column, double factor,
                                  double offset = 0.0) {
  std::vector<double> values = log[column];
  for (double& value : values) value = value * factor + offset;
  return values;
}

servo::PulledRecord read(const trace::Recording& log, const Options& options) {
  if (options.format == kZillen) {
    require_rising_time(log, "t_ms");
    return {.time_s = scaled_column(log, "t_ms", 1e-3),
            .position_m = scaled_column(log, "x_mm", 1e-3),
            .pressure_Pa = scaled_column(log, "p_bar", 1e5),
            .force_N = log["F_N"]};
  }
  const double ambient_Pa = 1e3 * options.ambient_kPa;
  require_rising_time(log, "time_s");
  require_between(log, "position_m", -kLongestStroke_m, kLongestStroke_m,
                  fmt::format("m, up to {:g} either way", kLongestStroke_m));
  require_absolute_pressure(log, "pressure_Pa", ambient_Pa);
  return {.time_s = log["time_s"],
          .position_m = log["position_m"],
          .pressure_Pa = scaled_column(log, "pressure_Pa", 1.0, -ambient_Pa),
          .force_N = log["force_N"]};
}

Pulled pulled(const std::string& file, const Options& options) {
  static const std::vector<std::string> kColumns{"time_s", "position_m", "pressure_Pa", "force_N"};
  static const std::vector<std::string> kZillenColumns{"t_ms", "x_mm", "p_bar", "F_N"};
  const bool zillen = options.format == kZillen;
  const trace::Recording log = read_bench(
      "friction", file, zillen ? kZillenColumns : kColumns,
      zillen ? std::vector<std::string>{"laser_V", "press_V", "force_V"} : std::vector<std::string>{});
  const servo::PulledRecord record = read(log, options);
  const auto [low, high] = std::minmax_element(record.position_m.begin(), record.position_m.end());
  const double end_m = 0.01 * options.ends_percent * (*high - *low);
  const std::vector<SlidingRow> rows = servo::sliding_rows(
      record, {.slowest_m_s = 1e-3 * options.slowest_mm_s, .from_m = *low + end_m, .to_m = *high - end_m});
  if (rows.empty()) {
    throw identify::CannotIdentify(
        fmt::format("{}: the piston slides nowhere at {:g} mm/s or faster", log.name, options.slowest_mm_s));
  }
  Pulled found{.name = log.name};
  const auto kept = static_cast<std::ptrdiff_t>(rows_before(rows.size(), kHeldOut));
  found.fitted.assign(rows.begin(), rows.begin() + kept);
  found.held_out.assign(rows.begin() + kept, rows.end());
  const auto away = std::count_if(found.fitted.begin(), found.fitted.end(),
                                  [](const SlidingRow& row) { return row.velocity_m_s > 0.0; });
  if (away == 0 || away == kept) {
    throw identify::CannotIdentify(
        fmt::format("{}: the rows to fit slide in one direction only, expected both to tell friction from "
                    "the zero of the force",
                    log.name));
  }
  for (const SlidingRow& row : rows) found.pressure_Pa += row.pressure_Pa / static_cast<double>(rows.size());
  return found;
}

struct Answer {
  std::vector<Pulled> records{};
  servo::FrictionFit fit{};
  Figures common{};
  Figures coulomb{};  ///< one a record
};

Answer identified(const Options& options) {
  Answer answer;
  std::vector<std::vector<SlidingRow>> fitted;
  for (const std::string& file : options.logs) {
    answer.records.push_back(pulled(file, options));
    fitted.push_back(answer.records.back().fitted);
  }
  const servo::FrictionTerms terms = options.terms();
  answer.fit = servo::fit_friction(fitted, terms);
  const servo::FrictionFit& fit = answer.fit;
  for (std::size_t r = 0; r < answer.records.size(); ++r) {
    Pulled& record = answer.records[r];
    double squares = 0.0;
    double frictionless = 0.0;
    for (const SlidingRow& row : record.held_out) {
      squares += std::pow(servo::predicted_force_N(fit, r, row, terms) - row.force_N, 2);
      frictionless += std::pow(fit.area_m2 * row.pressure_Pa + fit.zero_N - row.force_N, 2);
    }
    const auto rows = static_cast<double>(record.held_out.size());
    record.rms_N = std::sqrt(squares / rows);
    record.frictionless_N = std::sqrt(frictionless / rows);
  }
  const std::string no_friction = "below 0: these speeds do not tell it";
  const auto sign = [&](double value) { return value > 0.0 ? std::string() : no_friction; };
  answer.common = {
      {"area_m2", "area A", "mm2", 1e6, fit.area_m2, fit.area_error_m2, options.bore_mm ? "held" : ""},
      {"zero_N", "zero of the force F_0", "N", 1.0, fit.zero_N, fit.zero_error_N}};
  if (terms.viscous) {
    answer.common.push_back({"viscous_N_s_m", "viscous friction F_v", "N s/m", 1.0, fit.viscous_N_s_m,
                             fit.viscous_error_N_s_m, sign(fit.viscous_N_s_m)});
  }
  if (terms.stribeck_velocity_m_s) {
    answer.common.push_back({"stribeck_N", "Stribeck friction F_s", "N", 1.0, fit.stribeck_N,
                             fit.stribeck_error_N, sign(fit.stribeck_N)});
  }
  for (std::size_t r = 0; r < answer.records.size(); ++r) {
    answer.coulomb.push_back({"coulomb_N",
                              fmt::format("F_c at {:.4g} bar gauge", 1e-5 * answer.records[r].pressure_Pa),
                              "N", 1.0, fit.coulomb_N[r], fit.coulomb_error_N[r], sign(fit.coulomb_N[r])});
  }
  return answer;
}

/// The least and the greatest speed of the rows that slide one way [m/s]; none: 0.
std::pair<double, double> speeds(const Pulled& record, double direction) {
  std::pair<double, double> found{0.0, 0.0};
  for (const auto* rows : {&record.fitted, &record.held_out}) {
    for (const SlidingRow& row : *rows) {
      const double speed = direction * row.velocity_m_s;
      if (speed <= 0.0) continue;
      if (found.second == 0.0) found.first = speed;
      found = {std::min(found.first, speed), std::max(found.second, speed)};
    }
  }
  return found;
}

void print(const Options& options, const Answer& answer) {
  const Output& output = options.output;
  output.print("friction of {} recording{}, {:.0f} rows that slide; left {:.3g} N RMS of them\n",
               answer.records.size(), answer.records.size() == 1 ? "" : "s", answer.fit.samples,
               answer.fit.rms_N);
  print(output, answer.common, 2);
  print(output, answer.coulomb, 2);
  for (const Pulled& record : answer.records) {
    const auto out = speeds(record, 1.0);
    const auto back = speeds(record, -1.0);
    output.print(
        "{}: {:.3g} to {:.3g} mm/s against the pressure's force, {:.3g} to {:.3g} with it; held out, the "
        "last "
        "{} rows: {:.3g} N RMS, without friction {:.3g} N\n",
        record.name, 1e3 * out.first, 1e3 * out.second, 1e3 * back.first, 1e3 * back.second,
        record.held_out.size(), record.rms_N, record.frictionless_N);
  }
  if (options.stribeck_mm_s) {
    output.print("of F_s, {:.2g} is told apart from the other figures (1: all, 0: nothing)\n",
                 answer.fit.stribeck_shape);
  }
}

Json json_of(const Options& options, const Answer& answer) {
  Json json{{"schema", "plenum-friction/1"},
            {"parameters", to_json(answer.common)},
            {"rms_N", answer.fit.rms_N},
            {"rows", answer.fit.samples},
            {"records", Json::array()}};
  if (options.stribeck_mm_s) json["stribeck_shape"] = number(answer.fit.stribeck_shape);
  for (std::size_t r = 0; r < answer.records.size(); ++r) {
    const Pulled& record = answer.records[r];
    json["records"].push_back({{"file", record.name},
                               {"gauge_Pa", record.pressure_Pa},
                               {"coulomb_N", to_json(Figures{answer.coulomb[r]})["coulomb_N"]},
                               {"held_out_rows", record.held_out.size()},
                               {"held_out_rms_N", number(record.rms_N)},
                               {"held_out_rms_without_friction_N", number(record.frictionless_N)}});
  }
  return json;
}

report::Page page_of(const Options& options, const Answer& answer) {
  report::Page page("Friction of a cylinder, from a bench that pulls it");
  page.lead(
      "What the bench pulls with, less what the pressure on the piston accounts for, is friction: F_c of "
      "each "
      "recording, area and force zero of all, fitted to the first 60 % of the rows that slide.");
  std::vector<report::Tile> tiles;
  for (std::size_t r = 0; r < answer.records.size(); ++r)
    tiles.push_back({answer.coulomb[r].name, answer.coulomb[r].value, "N", {}, answer.records[r].name});
  page.tiles(std::move(tiles));
  Figures all = answer.common;
  all.insert(all.end(), answer.coulomb.begin(), answer.coulomb.end());
  page.section("Figures").table(
      table_of(all, fmt::format("{:.0f} rows, left {:.3g} N RMS", answer.fit.samples, answer.fit.rms_N)));
  const servo::FrictionTerms terms = options.terms();
  for (std::size_t r = 0; r < answer.records.size(); ++r) {
    const Pulled& record = answer.records[r];
    report::Curve measured{.name = "measured",
                           .x = {},
                           .y = {},
                           .stroke = report::Stroke::kPoints,
                           .ink = report::Ink::kNeutral};
    report::Curve model{.name = "fitted", .x = {}, .y = {}, .stroke = report::Stroke::kPoints};
    report::Curve force = measured;
    report::Curve predicted = model;
    for (const auto* rows : {&record.fitted, &record.held_out}) {
      for (const SlidingRow& row : *rows) {
        const double pressed_N = answer.fit.area_m2 * row.pressure_Pa + answer.fit.zero_N;
        const double predicted_N = servo::predicted_force_N(answer.fit, r, row, terms);
        measured.x.push_back(1e3 * row.velocity_m_s);
        measured.y.push_back(row.force_N - pressed_N);
        model.x.push_back(1e3 * row.velocity_m_s);
        model.y.push_back(predicted_N - pressed_N);
        force.x.push_back(row.time_s);
        force.y.push_back(row.force_N);
        predicted.x.push_back(row.time_s);
        predicted.y.push_back(predicted_N);
      }
    }
    report::LineChart over_time{.title = "Force",
                                .caption = fmt::format("Held out: {:.3g} N RMS, without friction {:.3g} N.",
                                                       record.rms_N, record.frictionless_N),
                                .y = {"Force", "N"},
                                .curves = {std::move(force), std::move(predicted)}};
    if (!record.held_out.empty()) over_time.marks.push_back(held_out_from(record.held_out.front().time_s));
    page.section(fmt::format("{}: {:.4g} bar gauge", record.name, 1e-5 * record.pressure_Pa))
        .row({report::XyChart{.title = "Friction over velocity",
                              .caption = "Force less pressure and force zero.",
                              .x = {"Velocity", "mm/s"},
                              .y = {"Friction", "N"},
                              .curves = {std::move(measured), std::move(model)}},
              std::move(over_time)});
  }
  return page;
}

int run(const Options& options) {
  const Answer answer = identified(options);
  print(options, answer);
  write_report(options.output, options.report, [&] { return page_of(options, answer); });
  options.output.finish(json_of(options, answer));
  return kDone;
}

}  // namespace

Command add_friction(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("friction", "Fit a cylinder's friction to recordings of a bench that pulls its piston");
  arguments
      .option("LOG", options->logs,
              "Recordings at one regulated pressure each, with the columns time_s, position_m (growing "
              "towards the "
              "pressure), pressure_Pa (absolute) and force_N (with the chamber's pressure)")
      .type_name("LOG.csv")
      .required();
  arguments
      .option("--format", options->format,
              "Of the recordings: csv, or zillen (columns t_ms, x_mm, p_bar gauge, F_N)")
      .one_of({"csv", kZillen})
      .show_default();
  arguments.option("--ambient", options->ambient_kPa, "Pressure of the surroundings, absolute [kPa]")
      .within(1.0, 1e3)
      .show_default();
  arguments
      .option(
          "--bore", options->bore_mm,
          "Hold the area at that of this bore [mm]: one pressure will do then (default: fit it, from two)")
      .within(0.1, 1e4);
  arguments.flag("--viscous", options->viscous,
                 "Fit F_v too: needs different speeds both ways (default: none)");
  arguments
      .option("--stribeck-velocity", options->stribeck_mm_s,
              "Fit F_s too, at this v_s [mm/s]: needs speeds from below to well above it (default: none)")
      .within(1e-6, 1e6);
  arguments.option("--slowest", options->slowest_mm_s, "Rows slide that are faster than this [mm/s]")
      .within(1e-6, 1e6)
      .show_default();
  arguments
      .option("--ends", options->ends_percent,
              "Leave out so much of the stroke at either end, where the bench turns round [%]")
      .within(0.0, 49.0)
      .show_default();
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum friction at-1-bar.csv at-5-bar.csv --report friction.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
