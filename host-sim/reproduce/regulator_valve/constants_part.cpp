// Table 3 and the ranges (10), (11): numbers that follow from others.
#include <cmath>

#include "host-sim/plant/regulator_valve/linear_model.hpp"
#include "host-sim/plant/regulator_valve/valve.hpp"
#include "host-sim/plant/root_between.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

// The pressure at which the force balance of the plunger, (25), leaves it where it neither fills nor vents.
double rest_pressure_Pa(const plant::regulator_valve::ValveConfig& valve, double screw_m) {
  return plant::root_between(
      [&](double pressure_Pa) {
        return plant::regulator_valve::plunger_at_rest_m(valve, screw_m, pressure_Pa);
      },
      valve.ambient_Pa, valve.supply_Pa);
}

}  // namespace

Part constants() {
  namespace valve = plant::regulator_valve;
  constexpr double kRatio = 0.528;  // as printed
  const valve::ValveConfig bench = valve::bench_valve();
  const valve::BlockedRange range = valve::blocked_range(bench);
  const double rest_screw_m = identify::regulator_valve::SystemConstants{}.rest_screw_m;
  return {
      .title = "(10)-(12), (26), Table 3: constants",
      .text =
          "Blocked-flow constant, critical ratio and the range of pressures in which both ports are blocked, "
          "from gamma = 1.4, R = 287.04 J/(kg K), T = 298 K, 8 bar and 1 bar absolute; and the equilibrium "
          "that Table 3 linearises about.",
      .findings = {
          {.item = "(15), Table 3",
           .quantity = "k_a",
           .unit = "s/m",
           .paper = 2.34e-3,
           .ours = valve::blocked_flow_s_m(bench.gas),
           .tolerance = 0.005e-3,
           .source = Source::kPapersOwnEquation},
          {.item = "section 3.2",
           .quantity = "critical pressure ratio (2/(gamma+1))^(gamma/(gamma-1))",
           .unit = "%",
           .paper = 52.8,
           .ours = 100.0 * bench.ambient_Pa / range.low_Pa,
           .tolerance = 0.05,
           .source = Source::kPapersOwnEquation},
          {.item = "(10)",
           .quantity = "p_atm / 0.528",
           .unit = "Pa",
           .paper = 1.894e5,
           .ours = bench.ambient_Pa / kRatio,
           .tolerance = 50.0,
           .source = Source::kPapersOwnEquation},
          {.item = "(10)",
           .quantity = "0.528 p_sup",
           .unit = "Pa",
           .paper = 4.224e5,
           .ours = kRatio * bench.supply_Pa,
           .tolerance = 50.0,
           .source = Source::kPapersOwnEquation},
          {.item = "(11)",
           .quantity = "lower end, gauge",
           .unit = "Pa",
           .paper = kPrintedLow_Pa,
           .ours = bench.ambient_Pa / kRatio - bench.ambient_Pa,
           .tolerance = 50.0,
           .source = Source::kPapersOwnEquation},
          {.item = "(11)",
           .quantity = "upper end, gauge",
           .unit = "Pa",
           .paper = kPrintedHigh_Pa,
           .ours = kRatio * bench.supply_Pa - bench.ambient_Pa,
           .tolerance = 50.0,
           .source = Source::kPapersOwnEquation},
          {.item = "(25), (26)",
           .quantity = "rest pressure of (25) at Table 3's 2.69 mm; beside it that of (26)",
           .unit = "Pa",
           .paper = bench.plunger_spring_N_m / bench.diaphragm_area_m2 * rest_screw_m,
           .ours = rest_pressure_Pa(bench, rest_screw_m),
           .tolerance = kPrintedSlope_Pa_m * 0.005e-3,
           .source = Source::kPapersOwnEquation,
           .instead = "(26)",
           .why = "(25) rests at p_atm + k_me x_p/A_d, (26) drops p_atm: it holds for gauge pressures alone, "
                  "while the p of (16), and so of (27), c_5 and c_8, is absolute"}}};
}

}  // namespace plenum::host::reproduce::regulator_valve
