// An orifice from the pressure of a vessel: a leak, a valve held open, a fitting.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host-sim/identify/orifice/fit_orifice.hpp"
#include "host-sim/identify/orifice/vessel_run.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/model_charts.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"
#include "host-sim/tools/vessel_input.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

namespace orifice = identify::orifice;
using orifice::OrificeFit;
using orifice::OrificeParameter;

constexpr double kFilter_s = 0.01;  // the moving average of the paper

struct Options {
  VesselInput input;
  double exponent = 1.4;
  double most_index = orifice::OrificeFitOptions{}.most_subsonic_index;
  bool thin_plate = false;
  std::string report;
  Output output;
};

/// One log's answer.
struct Found {
  VesselLog log;
  OrificeFit fit{};
  /// ISO 6358, dm3/(s bar) at its reference atmosphere: m = C rho_0 p sqrt(T_0/T) and k p = alpha R T m/V, and
  /// R T_0 rho_0 is 1 bar. T is the rig's. None where the volume is unknown.
  std::optional<double> sonic_conductance{};
  double sonic_conductance_error = 0.0;  ///< standard; that of the choked rate, volume and exponent as given

  const char* flow() const { return log.record.flow == orifice::Flow::kCharge ? "charge" : "discharge"; }
  /// " at 5 V"; empty for a sealed vessel.
  std::string at_command() const { return log.command_V ? fmt::format(" at {:.4g} V", *log.command_V) : ""; }
};

/// The fit, whose refusals name the file, and the way out where there is one.
OrificeFit fitted(const VesselLog& of, const orifice::Vessel& vessel, const orifice::OrificeFitOptions& how) {
  try {
    return orifice::fit_orifice(of.record, vessel, how);
  } catch (const orifice::ShapeNotSeen& why) {
    throw identify::CannotIdentify(
        fmt::format("{}: {}; --thin-plate holds the flow's shape", of.name, why.what()));
  } catch (const identify::CannotIdentify& why) {
    throw identify::CannotIdentify(fmt::format("{}: {}", of.name, why.what()));
  } catch (const std::invalid_argument& why) {
    throw trace::InputError(fmt::format("{}: {}", of.name, why.what()));
  }
}

Found find(const VesselLog& of, const trace::RigDescription& rig, const Options& options) {
  Found found{.log = of};
  orifice::OrificeFitOptions how;
  how.moving_average_rows = static_cast<std::size_t>(std::max(1.0, std::round(kFilter_s / of.period_s)));
  how.most_subsonic_index = options.most_index;
  if (options.thin_plate) how = orifice::held_at_thin_plate(how);
  orifice::Vessel vessel{.volume_m3 = of.volume_m3, .flow_exponent = options.exponent};
  const double reference_K = vessel.gas.temperature_K;
  vessel.gas.temperature_K = rig.gas.temperature_K;
  found.fit = fitted(of, vessel, how);
  if (!of.volume_m3) return found;
  const double per_rate =
      1e3 * *of.volume_m3 / options.exponent * std::sqrt(reference_K / rig.gas.temperature_K);
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

std::vector<Line> lines_of(const OrificeFit& fit) {
  std::vector<Line> lines{{"choked_rate", "1/s", 1.0, fit.choked_rate_1_s}};
  if (fit.area_m2) lines.push_back({"effective_area", "mm2", 1e6, *fit.area_m2});
  lines.push_back({"critical_ratio", "", 1.0, fit.critical_ratio});
  lines.push_back({"cracking_ratio", "", 1.0, fit.cracking_ratio});
  lines.push_back({"subsonic_index", "", 1.0, fit.subsonic_index});
  return lines;
}

/// What stands behind the number.
std::string conductance_text(const Found& found) {
  if (!found.sonic_conductance) return "not told: the file holds no volume; --volume gives it";
  return fmt::format("dm3/(s bar){}: the choked rate, times volume over exponent",
                     std::isfinite(found.sonic_conductance_error)
                         ? fmt::format(" +- {:.2g}", found.sonic_conductance_error)
                         : "");
}

void print(const Output& output, const Found& found) {
  const OrificeFit& fit = found.fit;
  const std::vector<double>& time_s = found.log.record.time_s;
  output.print("{}: {}{}{}, {:.4g} s, pressure ratio {:.3f} to {:.3f}\n", found.log.name, found.flow(),
               found.log.volume_m3 ? fmt::format(" of {:.6g} mL", 1e6 * *found.log.volume_m3) : "",
               found.at_command(), time_s.back() - time_s.front(), fit.least_ratio, fit.greatest_ratio);
  output.print("  {:<18} {:>12} {}\n", "sonic_conductance",
               found.sonic_conductance ? fmt::format("{:.6g}", *found.sonic_conductance) : "-",
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
  Json result{{"file", found.log.name},
              {"flow", found.flow()},
              {"command_V", number(found.log.command_V)},
              {"volume_m3", number(found.log.volume_m3)},
              {"least_pressure_ratio", fit.least_ratio},
              {"greatest_pressure_ratio", fit.greatest_ratio},
              {"sonic_conductance_dm3_s_bar", number(found.sonic_conductance)}};
  const auto add = [&result](const char* name, const OrificeParameter& of) {
    Json entry = to_json(of);
    entry["value"] = of.value;
    entry["held"] = of.held;
    entry["identified"] = of.identified;
    result["parameters"][name] = entry;
  };
  add("choked_rate_1_s", fit.choked_rate_1_s);
  if (fit.area_m2) add("area_m2", *fit.area_m2);
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
        scaled(orifice::free_run(found.fit.port_1_s(), found.log.record, found.fit.start_Pa), 1e-3);
    const std::vector<double> measured_kPa = scaled(found.log.record.vessel_Pa, 1e-3);
    std::vector<double> error_kPa = run_kPa;
    for (std::size_t row = 0; row < error_kPa.size(); ++row) error_kPa[row] -= measured_kPa[row];
    const std::string conductance =
        found.sonic_conductance ? fmt::format("{:.4g} ", *found.sonic_conductance) : "";
    report::Table table{
        .caption = fmt::format("Sonic conductance {}{}", conductance, conductance_text(found)),
        .columns = {"Parameter", "Value", "Standard error", "This log says"},
        .rows = {}};
    for (const Line& line : lines_of(found.fit)) {
      const std::string unit = *line.unit == '\0' ? "" : fmt::format(" [{}]", line.unit);
      table.rows.push_back({line.name + unit, fmt::format("{:.5g}", line.per_unit * line.of.value),
                            line.error().empty() ? "-" : line.error(),
                            line.remark().empty() ? "identified" : line.remark()});
    }
    page.section(fmt::format("{}: {}{}", found.log.name, found.flow(), found.at_command()))
        .row({report::LineChart{.title = "Pressure",
                                .caption = fmt::format("Mean absolute error {:.3g} kPa.",
                                                       1e-3 * found.fit.mean_absolute_error_Pa),
                                .y = {"Pressure", "kPa"},
                                .curves = {{"measured", found.log.record.time_s, measured_kPa,
                                            report::Stroke::kSolid, report::Ink::kNeutral},
                                           {"free run", found.log.record.time_s, run_kPa}},
                                .group = found.log.name},
              report::LineChart{.title = "Error",
                                .caption = "Free run minus measured.",
                                .y = {"Error", "kPa"},
                                .curves = {{"free run - measured", found.log.record.time_s, error_kPa}},
                                .group = found.log.name}})
        .table(std::move(table));
  }
  return page;
}

int run(const Options& options) {
  const trace::RigDescription rig = options.input.rig();
  std::vector<Found> all;
  for (const VesselLog& of : options.input.read(rig)) all.push_back(find(of, rig, options));
  for (const Found& found : all) options.input.tell(found.log);
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
  options->input.add_to(arguments);
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
