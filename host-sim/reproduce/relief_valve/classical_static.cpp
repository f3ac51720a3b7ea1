#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "host-sim/plant/relief_valve/two_stage_static.hpp"
#include "host-sim/reproduce/relief_valve/parts.hpp"
#include "host-sim/reproduce/relief_valve/printed.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::relief_valve {
namespace {

using namespace plant::relief_valve;

report::Curve curve(const std::string& name, const TwoStageConfig& config) {
  const TwoStagePhysics physics(config);
  const double least_in3_s = least_main_flow_m3_s(physics) / kInch3_m3;
  report::Curve curve{.name = name, .x = {0.0}, .y = {pilot_cracking_Pa(config) / kPsi_Pa}};
  for (int i = 0; i <= 150; ++i) {
    const double flow_in3_s = least_in3_s + (300.0 - least_in3_s) * (i + 1e-6) / 150.0;
    curve.x.push_back(flow_in3_s);
    curve.y.push_back(two_stage_at_rest(physics, flow_in3_s * kInch3_m3)[kP1] / kPsi_Pa);
  }
  return curve;
}

/// Largest force that a rest leaves unbalanced, of the main spring's preload.
double worst_unbalance(const TwoStageConfig& config) {
  const TwoStagePhysics physics(config);
  double worst = 0.0;
  for (int i = 1; i <= 30; ++i) {
    const TwoStageState s = two_stage_at_rest(physics, 10.0 * i * kInch3_m3);
    worst = greater_of(worst, std::abs(physics.main_force_N(s)));
    worst = greater_of(worst, std::abs(physics.pilot_force_N(s)));
  }
  return worst / (config.main.spring_N_m * config.main.preload_m);
}

}  // namespace

Part classical_static() {
  const TwoStageConfig printed = appendix_a_as_printed();
  const double stiffness_N_m =
      printed.bulk_modulus_Pa * printed.main_area_m2 * printed.main_area_m2 / printed.chamber_volume_m3;
  const double period_s = 2.0 * std::numbers::pi / std::sqrt(stiffness_N_m / printed.main.mass_kg);
  const TwoStagePhysics physics(printed);
  const auto rest_psi = [&](double flow_in3_s) {
    return two_stage_at_rest(physics, flow_in3_s * kInch3_m3)[kP1] / kPsi_Pa;
  };
  Part part{.title = "Appendix A, Fig. 25: classical two-stage valve at rest",
            .text = fmt::format("The static equations down to one scalar equation: with the spool's "
                                "displacement given, the pilot's balance gives the "
                                "chamber pressure, and what is left rises with the pilot's displacement. "
                                "(The paper iterates on the latter for a given "
                                "pressure.) Fig. 25 has no number that the scan keeps, so no point of it can "
                                "be compared; what can is the equations' own "
                                "residual and two numbers of the appendix that follow from others. The flow "
                                "force is the printed one, half of what the "
                                "momentum theorem gives. With the printed geometry the pilot cracks at "
                                "{:.0f} psi; 10, 200 and 250 in3/s pass at {:.1f}, "
                                "{:.1f} and {:.1f} psi. Pressure falls toward the end, because the term in "
                                "x^2 of the printed flow force turns it over.",
                                pilot_cracking_Pa(printed) / kPsi_Pa, rest_psi(10.0), rest_psi(200.0),
                                rest_psi(250.0)),
            .findings = {}};
  part.findings = {
      {.item = "II, Notation",
       .quantity = "area of the main spool, pi/4 (D3^2 - D2^2)",
       .unit = "in2",
       .paper = 1.436,
       .ours = std::numbers::pi / 4.0 * (1.5 * 1.5 - 0.65 * 0.65),
       .tolerance = 0.0005,
       .why = "the printed diameters give 1.4353 by this formula, which is ours: the paper prints none. "
              "1.436 is "
              "off by less than one in a thousand and is used as printed"},
      {.item = "dynamic analysis",
       .quantity = "steps of 3e-6 s in a period of the main spool on the chamber as a liquid spring",
       .paper = 100.0,
       .ours = period_s / 3e-6,
       .tolerance = 100.0 * 0.5 / 3.0,  // half the one digit of the step
       .instead = "1/100 of the period",
       .why =
           "the stiffness of the liquid spring, bulk modulus times area squared over volume, is our formula: "
           "the paper prints none, only the rule of 1/20 to 1/100 of the period. By it 1/100 of the period "
           "is 3.52e-6 s, just more than what rounds to "
           "3e-6 s"},
      {.item = "I to IV",
       .quantity =
           "largest unbalanced force of the rests from 10 to 300 in3/s, of the main preload (as printed)",
       .unit = "ppm",
       .paper = 0.0,
       .ours = 1e6 * worst_unbalance(printed),
       .tolerance = 0.01,
       .why = "the static equations are not solved"},
      {.item = "I to IV",
       .quantity =
           "largest unbalanced force of the rests from 10 to 300 in3/s, of the main preload (settling)",
       .unit = "ppm",
       .paper = 0.0,
       .ours = 1e6 * worst_unbalance(appendix_a_settling()),
       .tolerance = 0.01,
       .why = "the static equations are not solved"}};
  part.charts = {
      report::XyChart{.title = "Fig. 25: static characteristics by the classical model",
                      .x = {"Flow", "in3/s"},
                      .y = {"Upstream pressure", "psi"},
                      .curves = {curve("as printed", printed), curve("settling", appendix_a_settling())}}};
  return part;
}

}  // namespace plenum::host::reproduce::relief_valve
