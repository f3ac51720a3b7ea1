// An orifice from the pressure of a vessel: a leak, a valve held open, a fitting.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/identify/orifice/filter.hpp"
#include "host-sim/identify/orifice/fit_orifice.hpp"
#include "host-sim/identify/orifice/vessel_run.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/log_input.hpp"
#include "host-sim/tools/model_charts.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"

namespace plenum::host::tools {
namespace {

namespace orifice = identify::orifice;
using orifice::OrificeFit;
using orifice::OrificeParameter;

constexpr double kAtRest = 0.01;           // of its mean: more is a volume that moves
constexpr double kSameCommand_V = 1e-3;    // a 16-bit DAC's steps of 10 V are finer
constexpr double kFilter_s = 0.01;         // the moving average of the paper
constexpr double kThinPlateRatio = 0.528;  // b, with a = 1 and beta = 1/2

struct Options {
  LogInput input;
  std::vector<std::string> logs;
  double from_s = 0.0;
  std::optional<double> to_s;
  double exponent = 1.4;
  double most_index = orifice::OrificeFitOptions{}.most_subsonic_index;
  bool thin_plate = false;
  std::string report;
  Output output;
};

struct Part {
  std::size_t first = 0;
  std::size_t last = 0;  ///< the row after the last one
};

/// The rows in which the command of `first` is held.
Part held_from(const trace::Log& log, std::size_t first, std::size_t end) {
  Part part{first, first};
  while (part.last < end && std::abs(log.command_V[part.last] - log.command_V[first]) < kSameCommand_V)
    ++part.last;
  return part;
}

/// Whether the first row of `part` has the pressure before a step of the command: the mean of the tick before it.
bool begins_before_its_step(const trace::Log& log, const Part& part) {
  return part.first > 0 && log.pressure_average_s > 0.0 &&
         std::abs(log.command_V[part.first] - log.command_V[part.first - 1]) >= kSameCommand_V;
}

/// The rows between --from and --to, at one command and one volume; without the first where that is of the command
/// before. Throws CannotIdentify.
Part part_of(const trace::NamedLog& of, const Options& options) {
  const std::vector<double>& time_s = of.log.time_s;
  const auto row_at = [&](double t_s) {
    return static_cast<std::size_t>(std::lower_bound(time_s.begin(), time_s.end(), t_s) - time_s.begin());
  };
  Part asked{row_at(options.from_s), options.to_s ? row_at(*options.to_s) : time_s.size()};
  if (asked.last < asked.first + 3) {
    throw std::invalid_argument(fmt::format("{}: {} rows from --from {:g} s on, expected 3 or more", of.name,
                                            asked.last - std::min(asked.first, asked.last), options.from_s));
  }
  Part longest;
  for (std::size_t at = asked.first; at < asked.last;) {
    const Part held = held_from(of.log, at, asked.last);
    if (held.last - held.first > longest.last - longest.first) longest = held;
    at = held.last;
  }
  if (longest.last - longest.first < asked.last - asked.first) {
    throw identify::CannotIdentify(fmt::format(
        "{}: the command changes; expected one orifice at one command: the longest part at one is --from "
        "{}{}",
        of.name, time_s[longest.first],
        longest.last < time_s.size() ? fmt::format(" --to {}", time_s[longest.last]) : std::string()));
  }
  const auto begin = of.log.volume_m3.begin();
  const auto [least, most] = std::minmax_element(begin + static_cast<std::ptrdiff_t>(asked.first),
                                                 begin + static_cast<std::ptrdiff_t>(asked.last));
  if (*most - *least > kAtRest * *most) {
    throw identify::CannotIdentify(
        fmt::format("{}: the volume moves from {:.6g} to {:.6g} mL; expected a vessel at rest", of.name,
                    1e6 * *least, 1e6 * *most));
  }
  if (begins_before_its_step(of.log, asked)) ++asked.first;
  return asked;
}

std::vector<double> rows_of(const std::vector<double>& column, const Part& part) {
  return {column.begin() + static_cast<std::ptrdiff_t>(part.first),
          column.begin() + static_cast<std::ptrdiff_t>(part.last)};
}

orifice::VesselRecord record_of(const trace::Log& log, const trace::RigDescription& rig, const Part& part) {
  orifice::VesselRecord record;
  record.time_s = rows_of(log.time_s, part);
  for (double& t_s : record.time_s) t_s -= 0.5 * log.pressure_average_s;  // of which a row is the mean
  record.vessel_Pa = rows_of(log.pressure_Pa, part);
  const bool fills = record.vessel_Pa.back() > record.vessel_Pa.front();
  record.flow = fills ? orifice::Flow::kCharge : orifice::Flow::kDischarge;
  if (!fills) {
    record.far_Pa.assign(record.vessel_Pa.size(), rig.ambient.pressure_Pa);
  } else if (log.supply_Pa.empty()) {
    record.far_Pa.assign(record.vessel_Pa.size(), rig.supply.pressure_Pa);
  } else {
    record.far_Pa = rows_of(log.supply_Pa, part);
    record = orifice::steady_far_side(std::move(record));
  }
  return record;
}

/// One log's answer.
struct Found {
  std::string name;
  double command_V = 0.0;
  orifice::VesselRecord record;
  OrificeFit fit;
  double volume_m3 = 0.0;
  /// ISO 6358, dm3/(s bar) at its reference atmosphere: m = C rho_0 p sqrt(T_0/T) and k p = alpha R T m/V, and
  /// R T_0 rho_0 is 1 bar. T is the rig's.
  double sonic_conductance = 0.0;
  double sonic_conductance_error = 0.0;  ///< standard; that of the choked rate, volume and exponent as given

  const char* flow() const { return record.flow == orifice::Flow::kCharge ? "charge" : "discharge"; }
};

Found find(const trace::NamedLog& of, const trace::RigDescription& rig, const Options& options) {
  const Part part = part_of(of, options);
  Found found;
  found.name = of.name;
  found.command_V = of.log.command_V[part.first];
  found.record = record_of(of.log, rig, part);
  found.volume_m3 = mean(rows_of(of.log.volume_m3, part));
  orifice::OrificeFitOptions how;
  how.moving_average_rows = static_cast<std::size_t>(std::max(1.0, std::round(kFilter_s / of.log.period_s)));
  how.most_subsonic_index = options.most_index;
  if (options.thin_plate) {
    how.cracking_ratio = 1.0;
    how.critical_ratio = kThinPlateRatio;
    how.subsonic_index = 0.5;
  }
  orifice::Vessel vessel{.volume_m3 = found.volume_m3, .flow_exponent = options.exponent};
  const double reference_K = vessel.gas.temperature_K;
  vessel.gas.temperature_K = rig.gas.temperature_K;
  try {
    found.fit = orifice::fit_orifice(found.record, vessel, how);
  } catch (const identify::CannotIdentify& why) {
    throw identify::CannotIdentify(fmt::format(
        "{}: {}{}", of.name, why.what(), options.thin_plate ? "" : "; --thin-plate holds the flow's shape"));
  }
  const double per_rate =
      1e3 * found.volume_m3 / options.exponent * std::sqrt(reference_K / rig.gas.temperature_K);
  found.sonic_conductance = per_rate * found.fit.choked_rate_1_s.value;
  found.sonic_conductance_error = per_rate * found.fit.choked_rate_1_s.standard_error;
  return found;
}

struct Line {
  const char* name;
  const char* unit;
  double per_unit;
  const OrificeParameter& of;

  std::string error() const {
    return std::isfinite(of.standard_error) && !of.held ? fmt::format("{:.2g}", per_unit * of.standard_error)
                                                        : std::string();
  }
  std::string remark() const { return of.held ? "held" : of.why_not; }
};

std::array<Line, 5> lines_of(const OrificeFit& fit) {
  return {{{"choked_rate", "1/s", 1.0, fit.choked_rate_1_s},
           {"effective_area", "mm2", 1e6, *fit.area_m2},
           {"critical_ratio", "", 1.0, fit.critical_ratio},
           {"cracking_ratio", "", 1.0, fit.cracking_ratio},
           {"subsonic_index", "", 1.0, fit.subsonic_index}}};
}

/// What stands behind the number.
std::string conductance_text(const Found& found) {
  return fmt::format("dm3/(s bar){}: the choked rate, times volume over exponent",
                     std::isfinite(found.sonic_conductance_error)
                         ? fmt::format(" +- {:.2g}", found.sonic_conductance_error)
                         : "");
}

void print(const Output& output, const Found& found) {
  const OrificeFit& fit = found.fit;
  output.print("{}: {} of {:.6g} mL at {:.4g} V, {:.4g} s, pressure ratio {:.3f} to {:.3f}\n", found.name,
               found.flow(), 1e6 * found.volume_m3, found.command_V,
               found.record.time_s.back() - found.record.time_s.front(), fit.least_ratio, fit.greatest_ratio);
  output.print("  {:<18} {:>12.6g} {}\n", "sonic_conductance", found.sonic_conductance,
               conductance_text(found));
  for (const Line& line : lines_of(fit)) {
    output.print("  {:<18} {:>12.6g} {:<4} {:<12} {}\n", line.name, line.per_unit * line.of.value, line.unit,
                 line.error().empty() ? "" : "+- " + line.error(), line.remark());
  }
  output.print("  free run errs by {:.3f} kPa in the mean, {:.3f} kPa RMS; stopped after {} iterations: {}\n",
               1e-3 * fit.mean_absolute_error_Pa, 1e-3 * fit.rms_error_Pa, fit.iterations, fit.stop);
}

Json json_of(const Found& found) {
  const OrificeFit& fit = found.fit;
  Json result{{"file", found.name},
              {"flow", found.flow()},
              {"command_V", found.command_V},
              {"volume_m3", found.volume_m3},
              {"least_pressure_ratio", fit.least_ratio},
              {"greatest_pressure_ratio", fit.greatest_ratio},
              {"sonic_conductance_dm3_s_bar", found.sonic_conductance}};
  const auto add = [&result](const char* name, const OrificeParameter& of) {
    Json entry = to_json(of);
    entry["value"] = of.value;
    entry["held"] = of.held;
    entry["identified"] = of.identified;
    result["parameters"][name] = entry;
  };
  add("choked_rate_1_s", fit.choked_rate_1_s);
  add("area_m2", *fit.area_m2);
  add("critical_ratio", fit.critical_ratio);
  add("cracking_ratio", fit.cracking_ratio);
  add("subsonic_index", fit.subsonic_index);
  result["mean_absolute_error_kPa"] = 1e-3 * fit.mean_absolute_error_Pa;
  result["rms_error_kPa"] = 1e-3 * fit.rms_error_Pa;
  result["converged"] = fit.converged;
  result["stop"] = fit.stop;
  return result;
}

report::Page page_of(const std::vector<Found>& all) {
  report::Page page("Orifices, from the pressure of a vessel");
  page.lead(
      "How fast the pressure of a vessel changes is the flow: choked rate, critical pressure ratio, cracking "
      "ratio and subsonic index of the ISO 6358 flow function, fitted to the free run of the pressure.");
  for (const Found& found : all) {
    const std::vector<double> run_kPa =
        scaled(orifice::free_run(found.fit.port_1_s(), found.record, found.fit.start_Pa), 1e-3);
    const std::vector<double> measured_kPa = scaled(found.record.vessel_Pa, 1e-3);
    std::vector<double> error_kPa = run_kPa;
    for (std::size_t row = 0; row < error_kPa.size(); ++row) error_kPa[row] -= measured_kPa[row];
    report::Table table{.caption = fmt::format("Sonic conductance {:.4g} {}", found.sonic_conductance,
                                               conductance_text(found)),
                        .columns = {"Parameter", "Value", "Standard error", "This log says"},
                        .rows = {}};
    for (const Line& line : lines_of(found.fit)) {
      const std::string unit = *line.unit == '\0' ? "" : fmt::format(" [{}]", line.unit);
      table.rows.push_back({line.name + unit, fmt::format("{:.5g}", line.per_unit * line.of.value),
                            line.error().empty() ? "-" : line.error(),
                            line.remark().empty() ? "identified" : line.remark()});
    }
    page.section(fmt::format("{}: {} at {:.4g} V", found.name, found.flow(), found.command_V))
        .row({report::LineChart{.title = "Pressure",
                                .caption = fmt::format("Mean absolute error {:.3g} kPa.",
                                                       1e-3 * found.fit.mean_absolute_error_Pa),
                                .y = {"Pressure", "kPa"},
                                .curves = {{"measured", found.record.time_s, measured_kPa,
                                            report::Stroke::kSolid, report::Ink::kNeutral},
                                           {"free run", found.record.time_s, run_kPa}},
                                .group = found.name},
              report::LineChart{.title = "Error",
                                .caption = "Free run minus measured.",
                                .y = {"Error", "kPa"},
                                .curves = {{"free run - measured", found.record.time_s, error_kPa}},
                                .group = found.name}})
        .table(std::move(table));
  }
  return page;
}

int run(const Options& options) {
  const trace::RigDescription rig = options.input.rig();
  std::vector<Found> all;
  for (const trace::NamedLog& of : options.input.read(options.logs, rig))
    all.push_back(find(of, rig, options));
  options.input.print_assumed(options.output);
  Json results = Json::array();
  for (const Found& found : all) {
    print(options.output, found);
    results.push_back(json_of(found));
  }
  write_report(options.output, options.report, [&] { return page_of(all); });
  options.output.finish({{"orifices", results}});
  return std::all_of(all.begin(), all.end(), [](const Found& found) { return found.fit.converged; })
             ? kDone
             : kImpossible;
}

}  // namespace

Command add_orifice(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "orifice",
      "Fit an orifice, a leak or a valve held open, to the pressure of a vessel that fills or empties");
  arguments.option("LOG", options->logs, "Logs of a chamber at one command and one volume: an orifice each")
      .type_name("LOG.csv")
      .required();
  options->input.add_to(
      arguments,
      "What is known of the rig: the far side is its ambient pressure, of a vessel that fills its supply or "
      "the log's supply_Pa; the gas has its temperature (default: 700 and 101.325 kPa, 293.15 K)");
  arguments.option("--from", options->from_s, "Leave out what is before [s]").show_default();
  arguments.option("--to", options->to_s, "Leave out what is from there on [s] (default: the log's end)");
  arguments
      .option(
          "--exponent", options->exponent,
          "Of the gas in the vessel: 1.4 adiabatic, where it takes seconds; 1 isothermal, a leak of minutes")
      .within(1.0, 1.4)
      .show_default();
  arguments.flag("--thin-plate", options->thin_plate,
                 "Hold the flow's shape at that of a thin plate, for a vessel whose pressure hardly changes "
                 "(default: fit it)");
  arguments
      .option("--most-subsonic-index", options->most_index,
              "The subsonic index lies below: no valve's is above 1, but a leak through pores asks for more")
      .within(0.5, 100.0)
      .show_default();
  arguments
      .option("--report", options->report, "Page to write: pressure against its free run (default: none)")
      .type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(
      example("  plenum orifice --rig rig.toml --exponent 1 sealed-for-a-minute.csv --report leak.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
