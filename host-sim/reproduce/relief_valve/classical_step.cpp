#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "host-sim/plant/relief_valve/two_stage_run.hpp"
#include "host-sim/plant/relief_valve/two_stage_static.hpp"
#include "host-sim/reproduce/relief_valve/parts.hpp"
#include "host-sim/reproduce/relief_valve/printed.hpp"
#include "host-sim/reproduce/relief_valve/recorded.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::relief_valve {
namespace {

using namespace plant::relief_valve;

constexpr double kStep_s = 5e-5;
constexpr double kSupply_in3_s = 250.0;

struct Response {
  std::vector<double> time_s, pressure_psi, chamber_psi, spool_in, pilot_in;
  long events = 0;
};

/// The supply steps to 250 in3/s at 0 s, from rest at another flow, or (0) from the valve shut and without
/// pressure.
Response step_response(const TwoStageConfig& config, double from_in3_s, double duration_s) {
  const TwoStagePhysics physics(config);
  const TwoStageState start =
      from_in3_s > 0.0 ? two_stage_at_rest(physics, from_in3_s * kInch3_m3) : TwoStageState{};
  TwoStageValve valve(config, start);
  Response response;
  const int rows = static_cast<int>(std::lround(duration_s / kStep_s));
  for (int k = 0; k <= rows; ++k) {
    if (k > 0) valve.advance(kSupply_in3_s * kInch3_m3, kSupply_in3_s * kInch3_m3, kStep_s);
    response.time_s.push_back(kStep_s * k);
    response.pressure_psi.push_back(valve.state()[kP1] / kPsi_Pa);
    response.chamber_psi.push_back(valve.state()[kP2] / kPsi_Pa);
    response.spool_in.push_back(valve.state()[kX] / kInch_m);
    response.pilot_in.push_back(valve.state()[kY] / kInch_m);
  }
  response.events = valve.effort().events;
  return response;
}

/// Frequency of the pressure about `level_psi` (NaN: its mean) from a time on.
double frequency_Hz(const Response& response, double from_s, double level_psi) {
  const auto first = response.pressure_psi.begin() + std::lround(from_s / kStep_s);
  const std::vector<double> late(first, response.pressure_psi.end());
  const double mean = std::accumulate(late.begin(), late.end(), 0.0) / static_cast<double>(late.size());
  return crossing_frequency_Hz(late, kStep_s, std::isnan(level_psi) ? mean : level_psi);
}

Mode least_damped(const TwoStageConfig& config) {
  const TwoStagePhysics physics(config);
  const std::vector<Mode> all = modes(physics, two_stage_at_rest(physics, kSupply_in3_s * kInch3_m3));
  return *std::find_if(all.begin(), all.end(), [](const Mode& mode) { return mode.frequency_Hz > 0.0; });
}

/// Frequency and growth of the least damped mode over the pilot's area, one curve a damping.
std::vector<report::Chart> over_the_blanks() {
  report::XyChart frequency{.title = "Least damped mode over the two blanks: frequency",
                            .caption = "D4 = 0.04 in, 250 in3/s; B_p in lbf s/in.",
                            .x = {"Pilot area A_p", "in2"},
                            .y = {"Frequency", "Hz"},
                            .marks = {{report::Mark::On::kY, 130.0, "paper"}}};
  report::XyChart growth{.title = "Least damped mode over the two blanks: growth",
                         .x = {"Pilot area A_p", "in2"},
                         .y = {"Growth", "1/s"},
                         .marks = {{report::Mark::On::kY, 0.0, "limit of stability"}}};
  for (const double damping : {0.0, 0.02, 0.05}) {
    report::Curve f{.name = fmt::format("B_p = {}", damping), .x = {}, .y = {}};
    report::Curve g = f;
    for (int i = 0; i <= 20; ++i) {
      TwoStageConfig config = appendix_a_settling();
      const double area_in2 = 0.014 + 0.001 * i;
      config.pilot_area_m2 = area_in2 * kInch2_m2;
      config.pilot.drag_N_s_m = damping * kPoundForce_N / kInch_m;
      const Mode mode = least_damped(config);
      f.x.push_back(area_in2);
      f.y.push_back(mode.frequency_Hz);
      g.x.push_back(area_in2);
      g.y.push_back(mode.growth_1_s);
    }
    frequency.curves.push_back(std::move(f));
    growth.curves.push_back(std::move(g));
  }
  return {frequency, growth};
}

}  // namespace

Part classical_step() {
  const Response printed = step_response(appendix_a_as_printed(), 0.0, 0.1);
  const Response settling_from_rest = step_response(appendix_a_settling(), 0.0, 0.1);
  const Response settling = step_response(appendix_a_settling(), 200.0, 0.1);
  const TwoStagePhysics physics(appendix_a_settling());
  const double rest_psi = two_stage_at_rest(physics, kSupply_in3_s * kInch3_m3)[kP1] / kPsi_Pa;
  TwoStageConfig capillary_throughout = appendix_a_settling();
  capillary_throughout.chamber_follows_while_pilot_shut = false;
  const Response without_f = step_response(capillary_throughout, 200.0, 0.1);
  double least_psi = 0.0;
  for (const Response* response : {&printed, &settling_from_rest, &settling}) {
    for (const double psi : response->pressure_psi) least_psi = lesser_of(least_psi, psi);
    for (const double psi : response->chamber_psi) least_psi = lesser_of(least_psi, psi);
  }
  const Mode printed_mode = least_damped(appendix_a_as_printed());
  TwoStageConfig with_short_damping = appendix_a_as_printed();
  with_short_damping.main.damping_length_m *= 0.1;
  TwoStageConfig full_flow_force = appendix_a_as_printed();
  full_flow_force.flow_force_factor = 2.0;
  const Mode full_mode = least_damped(full_flow_force);
  const Mode settling_mode = least_damped(appendix_a_settling());
  const double nan = std::nan("");
  double swing = 0.0;
  const auto late = without_f.pressure_psi.end() - std::lround(0.02 / kStep_s);
  swing = *std::max_element(late, without_f.pressure_psi.end()) -
          *std::min_element(late, without_f.pressure_psi.end());

  Part part{
      .title = "Appendix A, Fig. 26: response of the classical two-stage valve to a step of flow",
      .text = fmt::format(
          "Six states, stops and positive pressures located as events. With the printed "
          "numbers, the capillary read as 0.01 in, and what is left blank taken from "
          "the geometry (A_p = pi/4 D6^2 = 0.0314 in2) or as nothing (B_p = 0), the valve is "
          "unstable: its mode of {:.1f} Hz grows at {:.0f} /s until the pilot "
          "beats between seat and stop ({} events in 0.1 s), a limit cycle. (With the flow "
          "force of the momentum theorem, twice the printed one, that mode is at {:.1f} Hz and "
          "grows at {:.0f} /s: the paper's 130 Hz lies between.) For a valve that settles the two "
          "blanks are chosen: A_p = 0.020 in2 and B_p = 0.02 lbf s/in give a damped mode of "
          "{:.1f} Hz ({:.0f} /s) at every flow, and the capillary is read as 0.04 in, since with "
          "0.01 in the spool closes at 0.02 in/s and cannot follow an oscillation back. That shows "
          "that the printed numbers allow 130 Hz, not that they give it. From rest, without "
          "pressure, this valve too ends in a limit cycle ({:.0f} Hz); the step from 200 to 250 "
          "in3/s settles, ringing at {:.1f} Hz from 50 to 100 ms. Neither number is a finding, since "
          "the blanks "
          "were chosen for 130 Hz. With the capillary's law in place of "
          "constraint VI.F the latter leaves {:.2f} psi of swing in the last 20 ms. Left out is the part of "
          "the unsteady flow force in proportion to P', whose formula the scan does not let be read; the "
          "damping "
          "lengths of the main spool stand there as 1,0.15 in and are read as 1 and 0.15 (with 0.1 and 0.15 "
          "the "
          "mode of the printed numbers would be at {:.1f} Hz).",
          printed_mode.frequency_Hz, printed_mode.growth_1_s, printed.events, full_mode.frequency_Hz,
          full_mode.growth_1_s, settling_mode.frequency_Hz, settling_mode.growth_1_s,
          frequency_Hz(settling_from_rest, 0.03, nan), frequency_Hz(settling, 0.05, rest_psi), swing,
          least_damped(with_short_damping).frequency_Hz),
      .findings = {}};
  part.findings = {
      {.item = "Fig. 26",
       .quantity = "frequency of the pressure, printed numbers, blanks from geometry, from rest",
       .unit = "Hz",
       .paper = 130.0,
       .ours = frequency_Hz(printed, 0.03, nan),
       .tolerance = 5.0,
       .why = "the printed numbers do not fix the valve: A_p, B_p and B_m are blank, D4 is in doubt in the "
              "scan. With "
              "A_p = pi/4 D6^2 and B_p = 0 it runs into a "
              "limit cycle between the pilot's seat and stop, slower than its own mode"},
      {.item = "Fig. 26",
       .quantity = "frequency of the least damped mode, printed numbers, blanks from geometry",
       .unit = "Hz",
       .paper = 130.0,
       .ours = printed_mode.frequency_Hz,
       .tolerance = 5.0,
       .why = "12 % low, and it grows; what the paper used for A_p and B_p is not printed"},
      {.item = "VI",
       .quantity = "lowest pressure in all responses shown",
       .unit = "psi",
       .paper = 0.0,
       .ours = least_psi,
       .tolerance = 1e-4,
       .expect = Expect::kAtLeast,
       .why = "constraint A is not kept"},
  };
  const auto line = [](const char* name, const Response& response, const std::vector<double>& y) {
    return report::Curve{.name = name, .x = response.time_s, .y = y};
  };
  part.charts = {
      report::LineChart{.title = "Fig. 26: upstream pressure after a step of flow from 0 to 250 in3/s",
                        .y = {"Upstream pressure", "psi"},
                        .curves = {line("as printed", printed, printed.pressure_psi),
                                   line("settling", settling_from_rest, settling_from_rest.pressure_psi)},
                        .group = "step"},
      report::LineChart{.title = "Pilot: displacement",
                        .y = {"Displacement", "in"},
                        .curves = {line("as printed", printed, printed.pilot_in),
                                   line("settling", settling_from_rest, settling_from_rest.pilot_in)},
                        .marks = {{report::Mark::On::kY, 0.12, "stop"}},
                        .group = "step"},
      report::LineChart{.title = "Upstream pressure after a step from 200 to 250 in3/s",
                        .y = {"Upstream pressure", "psi"},
                        .curves = {line("settling", settling, settling.pressure_psi),
                                   line("settling, without VI.F", without_f, without_f.pressure_psi)},
                        .marks = {{report::Mark::On::kY, rest_psi, "at rest"}}}};
  for (report::Chart& chart : over_the_blanks()) part.charts.push_back(std::move(chart));
  return part;
}

}  // namespace plenum::host::reproduce::relief_valve
