// Fig. 4: a chamber between two ports of 1 mm radius, and the scale of its flow.
#include <cmath>
#include <numbers>

#include "host-sim/plant/chamber.hpp"
#include "host-sim/plant/reach.hpp"
#include "host-sim/reproduce/actuators/illustrated.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

constexpr double kCommand_V = 5.0;          // of no influence: both areas are fixed
constexpr double kSmallVolume_m3 = 0.1e-6;  // "of a fully retracted cylinder", III

/// Both ports open by pi mm2, whatever the command.
plant::Valve two_fixed_ports() {
  plant::ThinPlateValveConfig config;
  config.inlet_area_per_V_m2 = config.exhaust_area_per_V_m2 = config.transition_m2 = 0.0;
  config.inlet_leak_m2 = config.exhaust_leak_m2 = 1e-6 * std::numbers::pi;
  return plant::ThinPlateValve(config);
}

double rest_from(double start_Pa) {
  plant::ChamberConfig config;
  config.supply_Pa = kSupply_Pa;
  config.initial_pressure_Pa = start_Pa;
  config.tolerance_Pa = 0.01;
  plant::ChamberPlant chamber(two_fixed_ports(), config, plant::VolumeMotion(100e-6));
  return chamber.advance(kCommand_V, 5.0).end_Pa;
}

}  // namespace

Part two_port_chamber() {
  const plant::Valve ports = two_fixed_ports();
  const plant::Gas gas;
  const double RT = gas.specific_gas_constant_J_kg_K() * gas.temperature_K;
  Part part{
      .title = "Fig. 4: flow into a chamber with two ports",
      .text =
          "(2) with a_c = a_r = pi mm2, over the pressure of the chamber; and a chamber of 100 mL left to "
          "(4) from either end.",
      .findings = {}};

  const std::vector<double> pressure_Pa = evenly(1e3, kSupply_Pa, 2001);
  const std::vector<double> flow = over(pressure_Pa, [&](double p) {
    return plant::mass_flow_kg_s(ports, p, kCommand_V, kSupply_Pa, kAmbient_Pa);
  });
  const double rest_Pa = plant::steady_state_Pa(ports, kCommand_V, kSupply_Pa, kAmbient_Pa);
  part.findings.push_back({.item = "Fig. 4",
                           .quantity = "rising steps of the flow over the pressure, of 2000",
                           .paper = 0.0,
                           .ours = static_cast<double>(rising_steps(flow))});
  const double apart_Pa =
      greater_of(std::abs(rest_from(kAmbient_Pa) - rest_Pa), std::abs(rest_from(kSupply_Pa) - rest_Pa));
  part.findings.push_back(
      {.item = "II.A.2",
       .quantity = "where a chamber comes to rest from P_r and from P_c, off the root of (2)",
       .unit = "kPa",
       .paper = 0.0,
       .ours = 1e-3 * apart_Pa,
       .tolerance = 1e-3});

  const double filling_kg_s = plant::mass_flow_kg_s(ports, kAmbient_Pa, kCommand_V, kSupply_Pa, kAmbient_Pa);
  const double emptying_kg_s = plant::mass_flow_kg_s(ports, kSupply_Pa, kCommand_V, kSupply_Pa, kAmbient_Pa);
  const double span_cm3_s = 1e6 * (filling_kg_s - emptying_kg_s) * RT / kAmbient_Pa;
  part.findings.push_back(
      {.item = "III, Fig. 4",
       .quantity = "\"the vertical scale\": log10 of the span of the flow from P_r to P_c, cm3/s of room air",
       .paper = 4.0,
       .ours = std::log10(span_cm3_s),
       .tolerance = 0.5,
       .why = "by (1) and (11)-(13) at 20 degC, which the paper leaves open, orifices of 1 mm radius pass "
              "less"});
  const double rate_Pa_s = gas.kappa * RT / kSmallVolume_m3 * filling_kg_s;
  part.findings.push_back(
      {.item = "III",
       .quantity = "order of magnitude of the time scale of 0.1 cm3: log10 of p/pdot in seconds",
       .paper = -5.0,
       .ours = std::log10(kAmbient_Pa / rate_Pa_s),
       .tolerance = 0.5,
       .why = "(4a) at room pressure behind a port of 1 mm radius"});

  report::XyChart chart{.title = "Fig. 4: flow into a chamber with two ports of 1 mm radius",
                        .x = {"Pressure of the chamber", "kPa"},
                        .y = {"Flow, as room air", "cm3/s"}};
  report::Curve curve{.name = "(2)", .x = {}, .y = {}};
  for (std::size_t i = 0; i < flow.size(); i += 5) {
    curve.x.push_back(1e-3 * pressure_Pa[i]);
    curve.y.push_back(1e6 * flow[i] * RT / kAmbient_Pa);
  }
  chart.curves = {
      std::move(curve),
      {.name = "steady state", .x = {1e-3 * rest_Pa}, .y = {0.0}, .stroke = report::Stroke::kPoints}};
  part.charts.push_back(std::move(chart));
  return part;
}

}  // namespace plenum::host::reproduce::actuators
