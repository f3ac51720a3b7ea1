// Fig. 2 and (12)-(16): the flow through the ports.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host-sim/plant/regulator_valve/linear_model.hpp"
#include "host-sim/plant/regulator_valve/valve.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::regulator_valve {

Part nozzle() {
  namespace valve = plant::regulator_valve;
  constexpr int kPoints = 400;
  constexpr double kOpen_m = 0.1e-3;
  const valve::ValveConfig bench = valve::bench_valve();
  const valve::Ports ports(bench);
  const double x_m = valve::overlap_m(bench) + kOpen_m;
  const double blocked_kg_s =
      bench.inlet_width_m * kOpen_m * valve::blocked_flow_s_m(bench.gas) * bench.supply_Pa;  // (15)
  const valve::BlockedRange range = valve::blocked_range(bench);

  report::Curve curve{.name = "inlet", .x = {}, .y = {}};
  double off_blocked = 0.0;
  int rises = 0;
  for (int i = 0; i <= kPoints; ++i) {
    const double p_Pa = bench.supply_Pa * i / kPoints;
    const double flow = ports.inlet_kg_s(x_m, std::max(p_Pa, 1.0)) / blocked_kg_s;
    if (p_Pa < range.high_Pa) off_blocked = greater_of(off_blocked, std::abs(flow - 1.0));
    if (i > 0 && flow > curve.y.back() + 1e-12) ++rises;
    curve.x.push_back(p_Pa / bench.supply_Pa);
    curve.y.push_back(flow);
  }
  double off_exhaust = 0.0;
  for (double p_Pa = range.low_Pa; p_Pa <= range.high_Pa; p_Pa += 1e3) {
    const double printed =
        bench.exhaust_width_m * kOpen_m * valve::blocked_flow_s_m(bench.gas) * p_Pa;  // (16)
    off_exhaust = greater_of(off_exhaust, std::abs(ports.exhaust_kg_s(-kOpen_m, p_Pa) / printed - 1.0));
  }
  const double jump = ports.inlet_kg_s(x_m, range.high_Pa * (1.0 + 1e-9)) / blocked_kg_s - 1.0;

  return {
      .title = "Fig. 2, (12)-(16): flow through the ports",
      .text =
          "The inlet of the simulated valve, opened by 0.1 mm, over the pressure behind it, and the exhaust "
          "over the "
          "pressure before it. Blocked below 52.8 %, as (15) and (16) have it; above, where the paper has no "
          "equation, the isentropic nozzle.",
      .findings = {{.item = "Fig. 2, (15)",
                    .quantity = "largest relative distance from (15) below 52.8 %",
                    .paper = 0.0,
                    .ours = off_blocked,
                    .tolerance = 1e-9,
                    .why = "the blocked branch of the plant is not (15)"},
                   {.item = "(16)",
                    .quantity = "largest relative distance of the exhaust from (16) within (10)",
                    .paper = 0.0,
                    .ours = off_exhaust,
                    .tolerance = 1e-9,
                    .why = "the blocked branch of the plant is not (16)"},
                   {.item = "Fig. 2",
                    .quantity = "relative jump of the flow at 52.8 %",
                    .paper = 0.0,
                    .ours = jump,
                    .tolerance = 1e-6,
                    .why = "the branches do not meet"},
                   {.item = "Fig. 2",
                    .quantity = "rising steps of the flow over the pressure ratio, of 400",
                    .paper = 0.0,
                    .ours = static_cast<double>(rises),
                    .why = "the nozzle's flow is not monotone"},
                   {.item = "Fig. 2",
                    .quantity = "flow at equal pressures over the blocked flow",
                    .paper = 0.0,
                    .ours = curve.y.back(),
                    .tolerance = 1e-12,
                    .why = "the nozzle passes without a difference of pressure"}},
      .charts = {report::XyChart{.title = "Fig. 2: mass flow over the pressure ratio",
                                 .caption = "Blocked up to 0.528, then falling to nothing.",
                                 .x = {"Downstream over upstream pressure", ""},
                                 .y = {"Flow over blocked flow", ""},
                                 .curves = {curve},
                                 .marks = {{report::Mark::On::kX, 0.528, "0.528"}}}}};
}

}  // namespace plenum::host::reproduce::regulator_valve
