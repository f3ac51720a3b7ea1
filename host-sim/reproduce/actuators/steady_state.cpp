// Fig. 7: the pressure at which a chamber rests, over the command; and its measurement by a slow ramp, Fig.
// 10.
#include <algorithm>
#include <cmath>

#include "host-sim/plant/chamber.hpp"
#include "host-sim/plant/reach.hpp"
#include "host-sim/reproduce/actuators/curve_figures.hpp"
#include "host-sim/reproduce/actuators/illustrated.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

constexpr double kRamp_s = 10000.0;  // from 3 to 7 V
constexpr std::size_t kRampSteps = 4000;

double rest_kPa(const plant::ThinPlateValveConfig& valve, double u) {
  return 1e-3 * plant::steady_state_Pa(plant::ThinPlateValve(valve), u, kSupply_Pa, kAmbient_Pa);
}

std::vector<double> rests_kPa(const plant::ThinPlateValveConfig& valve,
                              const std::vector<double>& command_V) {
  return over(command_V, [&](double u) { return rest_kPa(valve, u); });
}

/// A locked cylinder of 100 mL while the command creeps from 3 to 7 V.
report::Curve slow_ramp(const plant::ThinPlateValveConfig& valve) {
  plant::ChamberConfig config;
  config.supply_Pa = kSupply_Pa;
  config.initial_pressure_Pa = kAmbient_Pa;
  plant::ChamberPlant chamber(plant::ThinPlateValve(valve), config, plant::VolumeMotion(100e-6));
  report::Curve ramp{.name = "slow ramp", .x = evenly(kLow_V, kHigh_V, kRampSteps + 1), .y = {}};
  for (const double u : ramp.x) {
    ramp.y.push_back(1e-3 * chamber.advance(u, kRamp_s / static_cast<double>(kRampSteps)).end_Pa);
  }
  return ramp;
}

}  // namespace

Part steady_state() {
  Part part{
      .title = "Fig. 7 and 10: steady-state pressure over the command",
      .text =
          "Roots of (2) with (3) for three guesses of the valve's constants (ours: the paper prints none), "
          "and the paper's way to measure them: a locked cylinder, the command from 3 to 7 V at 0.4 mV/s.",
      .findings = {}};
  report::XyChart chart{.title = "Fig. 7: predicted steady-state pressure",
                        .caption = "Lines: roots of (2). Dots: the slow ramp on a locked chamber of 100 mL.",
                        .x = {"Command", "V"},
                        .y = {"Pressure", "kPa"}};
  std::size_t falls = 0;
  double lowest_kPa = 1e9;
  double highest_kPa = 0.0;
  double ramp_off_kPa = 0.0;
  for (const IllustratedValve& one : illustrated_valves()) {
    report::Curve roots{.name = one.name, .x = evenly(kLow_V, kHigh_V, 401), .y = {}};
    roots.y = rests_kPa(one.valve, roots.x);
    falls += falling_steps(roots.y);
    lowest_kPa = lesser_of(lowest_kPa, roots.y.front());
    highest_kPa = greater_of(highest_kPa, roots.y.back());
    const report::Curve ramp = slow_ramp(one.valve);
    const std::vector<double> at_ramp = rests_kPa(one.valve, ramp.x);
    report::Curve dots{.name = one.name, .x = {}, .y = {}, .stroke = report::Stroke::kPoints};
    for (std::size_t i = 0; i < ramp.x.size(); ++i) {
      ramp_off_kPa = greater_of(ramp_off_kPa, std::abs(ramp.y[i] - at_ramp[i]));
      if (i % 100 == 0) {
        dots.x.push_back(ramp.x[i]);
        dots.y.push_back(ramp.y[i]);
      }
    }
    chart.curves.push_back(std::move(roots));
    chart.curves.push_back(std::move(dots));
  }
  part.findings.push_back({.item = "Fig. 7",
                           .quantity = "falling steps of p_ss over 3 to 7 V, three guesses, of 1200",
                           .paper = 0.0,
                           .ours = static_cast<double>(falls)});
  part.findings.push_back({.item = "Fig. 7, (10c)",
                           .quantity = "lower end of the sigmoid: P_r",
                           .unit = "kPa",
                           .paper = 1e-3 * kAmbient_Pa,
                           .ours = lowest_kPa,
                           .tolerance = 0.01e-3 * kSpan_Pa});
  part.findings.push_back({.item = "Fig. 7, (10c)",
                           .quantity = "upper end of the sigmoid: P_c",
                           .unit = "kPa",
                           .paper = 1e-3 * kSupply_Pa,
                           .ours = highest_kPa,
                           .tolerance = 0.01e-3 * kSpan_Pa});
  const plant::ThinPlateValveConfig wide = illustrated_valves()[0].valve;
  part.findings.push_back(
      {.item = "III.A, Fig. 7",
       .quantity =
           "\"a flat kink at the origin\" (below half of the steepest): slope there over the steepest, "
           "spool wider than the ports",
       .paper = kFlatKink,
       .ours = slope_at_null_over_steepest([&](double u) { return rest_kPa(wide, u); }, 5.0),
       .expect = Expect::kAtMost,
       .instead = "our reading of \"a flat kink\"",
       .why = "the transition of our guess is too wide for its sealed region"});
  part.findings.push_back(
      {.item = "III.A, V.B",
       .quantity = "slow ramp on a locked chamber, largest distance from the roots of (2)",
       .unit = "kPa",
       .paper = 0.01e-3 * kSpan_Pa,
       .ours = ramp_off_kPa,
       .expect = Expect::kAtMost,
       .instead = "our bound, 1 % of span",
       .why = "0.4 mV/s is not slow enough where both ports are sealed"});
  part.findings.push_back(
      {.item = "(2), (10c), Table I",
       .quantity = "steady state at (U_c + U_r)/2 with equal leaks, where (10) has c_b = (P_c + P_r)/2",
       .unit = "kPa",
       .paper = 0.5e-3 * (kSupply_Pa + kAmbient_Pa),
       .ours = rest_kPa(wide, 5.0),
       .tolerance = 0.01e-3 * kSpan_Pa,
       .why = "our valve has equal leaks, of which the paper says nothing. With equal areas (2) rests at "
              "0.81 P_c, because the exhaust is choked there and the "
              "supply is not, while g(0) = 0 puts (10c) half-way; so c_1 cannot be (U_c + U_r)/2 as "
              "Table I has it, nor the kink lie at the middle of the sigmoid"});
  part.charts.push_back(std::move(chart));
  return part;
}

}  // namespace plenum::host::reproduce::actuators
