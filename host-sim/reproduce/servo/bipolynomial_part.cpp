#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "host-sim/identify/servo/bipolynomial.hpp"
#include "host-sim/identify/servo/parabolic_orifice.hpp"
#include "host-sim/plant/mpye_tables.hpp"
#include "host-sim/plant/valve.hpp"
#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace identify::servo;

constexpr double kSupply_Pa = 700e3;
constexpr double kAmbient_Pa = 100e3;
constexpr double kGrid_Pa = 20e3;

struct MeasuredPort {
  const char* name;
  const plant::MpyeTable* table;
  plant::MpyeChannel channel;
  bool inlet;
};

// The flow of one port of the measured valve at the commands that were measured, over the chamber's
// pressures.
std::vector<FlowSample> samples_of(const MeasuredPort& port) {
  const plant::MpyeValve valve(port.channel);
  std::vector<FlowSample> samples;
  for (std::size_t i = 0; i < plant::kMpyeRows; ++i) {
    if ((*port.table)[i].area_m2 == 0.0) continue;
    const double table_V = plant::kMpyeStep_V * static_cast<double>(i);
    const auto opening = valve.opening(port.channel == plant::MpyeChannel::a ? table_V : 10.0 - table_V);
    for (double P = kAmbient_Pa; P <= kSupply_Pa + 1.0; P += kGrid_Pa) {
      const plant::PortFlows flows = valve.flows(opening, P, kSupply_Pa, kAmbient_Pa);
      samples.push_back({table_V, P, port.inlet ? flows.inlet_kg_s : flows.exhaust_kg_s});
    }
  }
  return samples;
}

// How many terms a fitted polynomial has: those that it was not given are exactly 0.
double terms_of(const Bipolynomial& polynomial) {
  double count = 0.0;
  for (const auto& of_u : polynomial.c)
    for (const double c : of_u) count += c != 0.0 ? 1.0 : 0.0;
  return count;
}

report::XyChart drawn(const MeasuredPort& port, const std::vector<FlowSample>& samples,
                      const Bipolynomial& polynomial) {
  report::XyChart chart{.title = fmt::format("{}: measured valve and bipolynomial", port.name),
                        .x = {"Chamber pressure", "kPa"},
                        .y = {"Mass flow", "g/s"}};
  double drawn_V = -1.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const FlowSample& s = samples[i];
    if (std::abs(s.command_V - std::round(s.command_V)) > 1e-9) continue;
    if (s.command_V != drawn_V) {
      drawn_V = s.command_V;
      chart.curves.push_back({.name = "tables",
                              .x = {},
                              .y = {},
                              .stroke = report::Stroke::kPoints,
                              .ink = report::Ink::kNeutral});
      chart.curves.push_back({.name = "(5)", .x = {}, .y = {}});
    }
    report::Curve& table = chart.curves[chart.curves.size() - 2];
    report::Curve& fitted = chart.curves.back();
    table.x.push_back(1e-3 * s.pressure_Pa);
    table.y.push_back(1e3 * s.flow_kg_s);
    fitted.x.push_back(1e-3 * s.pressure_Pa);
    fitted.y.push_back(1e3 * polynomial.flow_kg_s(s.command_V, s.pressure_Pa));
  }
  return chart;
}

}  // namespace

Part bipolynomial_part() {
  const std::vector<MeasuredPort> ports{
      {"inlet A", &plant::kMpyeChannelAInlet, plant::MpyeChannel::a, true},
      {"exhaust A", &plant::kMpyeChannelAExhaust, plant::MpyeChannel::a, false},
      {"inlet B", &plant::kMpyeChannelBInlet, plant::MpyeChannel::b_mirrored, true},
      {"exhaust B", &plant::kMpyeChannelBExhaust, plant::MpyeChannel::b_mirrored, false}};
  Part part;
  part.title = "(4), (5): bipolynomial flow";
  part.text =
      "(5) fitted to the measured MPYE-5-3/8-010-B valve at 7 bar, at each command with a measured area and "
      "1 to 7 bar in the chamber. The "
      "paper's own valve, a flapper on a nozzle, is not printed. Its claim is that (5) is more accurate than "
      "what came before: here the "
      "orifice (2) with an area parabolic in the command. Errors of full scale, as printed (8 terms) and "
      "with all 9:";
  for (const MeasuredPort& port : ports) {
    const std::vector<FlowSample> samples = samples_of(port);
    const BipolynomialFit printed = fit_bipolynomial(samples, Terms::kAsPrinted);
    const BipolynomialFit whole = fit_bipolynomial(samples, Terms::kWhole);
    const double percent = 100.0 / whole.full_scale_kg_s;
    part.text += fmt::format(
        " {}: {:.1f} % RMS, {:.0f} % at most ({:.1f}, {:.0f}), {} of {} samples the wrong way, or where "
        "nothing flows;",
        port.name, percent * printed.rms_kg_s, percent * printed.largest_kg_s, percent * whole.rms_kg_s,
        percent * whole.largest_kg_s, printed.wrong_way, samples.size());
    part.findings.push_back(
        {.item = "(5)",
         .quantity = fmt::format("RMS error on {}, of full scale; beside it that of (2)", port.name),
         .unit = "%",
         .paper = percent * fit_parabolic_orifice(samples, {port.inlet, kSupply_Pa, kAmbient_Pa}).rms_kg_s,
         .ours = percent * printed.rms_kg_s,
         .expect = Expect::kAtMost,
         .instead = "orifice (2) on the same tables",
         .why = "The paper claims this of another valve, a plate on a nozzle, and not of this one: a spool "
                "valve's flow is flat where it is choked and falls as a root, and a parabola in P has "
                "neither."});
    part.charts.push_back(drawn(port, samples, printed.polynomial));
  }
  part.text.back() = '.';
  part.findings.push_back(
      {.item = "(5)",
       .quantity = "terms of a second-order bipolynomial",
       .paper = terms_of(fit_bipolynomial(samples_of(ports.front()), Terms::kAsPrinted).polynomial),
       .ours = terms_of(fit_bipolynomial(samples_of(ports.front()), Terms::kWhole).polynomial),
       .source = Source::kPapersOwnEquation,
       .why =
           "(5) is called a second-order bipolynomial and its list of coefficients has an e that no "
           "term carries: the one in u alone is missing. (The list also lacks the c that one does carry.)"});
  return part;
}

}  // namespace plenum::host::reproduce::servo
