// Table 3 and the ranges (10), (11): numbers that follow from others.
#include <cmath>

#include "host-sim/plant/regulator_valve/linear_model.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"

namespace plenum::host::reproduce::regulator_valve {

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
          {.item = "(26), Table 3, (11)",
           .quantity = "rest pressure of x_p = 2.69 mm at 1.56e5 Pa/mm, at most the upper end of (11), gauge",
           .unit = "Pa",
           .paper = kPrintedHigh_Pa,
           .ours = kPrintedSlope_Pa_m * rest_screw_m,
           .expect = Expect::kAtMost,
           .source = Source::kPapersOwnEquation,
           .why = "Table 3's x_p = 2.69 mm put to (26) with section 4's 1.56e5 Pa/mm rests at 4.20e5 Pa, "
                  "outside (11), "
                  "for which alone (29) is derived; less the dead band of 0.9 mm, which (26) does not have, "
                  "it would be "
                  "2.79e5 Pa and inside"},
          {.item = "(25), (26)",
           .quantity = "rest pressure of (25) less that of (26), in the absolute pressures that (16) needs",
           .unit = "Pa",
           .paper = 0.0,
           .ours = bench.ambient_Pa,
           .source = Source::kPapersOwnEquation,
           .why =
               "(25) rests at p_atm + k_me x_p/A_d, (26) drops p_atm: it holds for gauge pressures, while "
               "the p of "
               "(16), and so of (27) and c_5, c_8, is absolute; k_2 comes out too large by p/(p - p_atm)"}}};
}

}  // namespace plenum::host::reproduce::regulator_valve
