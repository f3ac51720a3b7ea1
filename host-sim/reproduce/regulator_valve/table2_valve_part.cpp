// What the valve of Table 2 would do, had it the printed constants.
#include <fmt/format.h>

#include <cmath>

#include "host-sim/identify/regulator_valve/discrete_model.hpp"
#include "host-sim/plant/regulator_valve/linear_model.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace valve = plant::regulator_valve;

valve::ValveConfig with(const identify::regulator_valve::InternalParameters& table) {
  valve::ValveConfig config;
  config.plunger_mass_kg = table.plunger_mass_kg;
  config.spool_mass_kg = table.spool_mass_kg;
  config.plunger_spring_N_m = table.plunger_spring_N_m;
  config.spool_spring_N_m = table.spool_spring_N_m;
  config.diaphragm_area_m2 = table.diaphragm_area_m2;
  config.inlet_width_m = table.inlet_width_m;
  config.exhaust_width_m = table.exhaust_width_m;
  return config;
}

}  // namespace

Part valve_of_table2() {
  Part part{.title = "Table 2, 3: the valve they describe",
            .text =
                "The printed constants put to (26), (28) and (32), beside what section 4 measured on the "
                "valve they were identified from.",
            .findings = {}};
  const auto add = [&](const char* method, const identify::regulator_valve::InternalParameters& table) {
    const valve::ThirdOrder rising = valve::linear_pressurisation(with(table));
    const double rest_screw_m = identify::regulator_valve::SystemConstants{}.rest_screw_m;
    part.findings.push_back({.item = "Table 2, (26)",
                             .quantity = fmt::format("k_me/A_d, {}", method),
                             .unit = "Pa/mm",
                             .paper = 1e-3 * kPrintedSlope_Pa_m,
                             .ours = 1e-3 * rising.static_gain_Pa_m(),
                             .tolerance = 0.005e5,
                             .source = Source::kPapersOwnEquation,
                             .why = "Table 2 is a thousand times below section 4's 1.56e5 Pa/mm: its A_d, a "
                                    "plate of 18 cm by 10 cm, is 1000 times too large for its spring"});
    part.findings.push_back(
        {.item = "Table 2, 3, (26), (11)",
         .quantity =
             fmt::format("rest pressure of x_p = 2.69 mm, at least the lower end of (11), {}", method),
         .unit = "Pa",
         .paper = kPrintedLow_Pa,
         .ours = rising.static_gain_Pa_m() * rest_screw_m,
         .expect = Expect::kAtLeast,
         .source = Source::kPapersOwnEquation,
         .why = "(26) with Table 2 and 3 rests a thousand times lower, far outside (11)"});
    part.findings.push_back({.item = "Table 2, (28), Fig. 5",
                             .quantity = fmt::format("slowest time constant of (28), {}", method),
                             .unit = "s",
                             .paper = kPrintedTimeConstant_s,
                             .ours = identify::regulator_valve::slowest_time_constant_s(rising),
                             .tolerance = 0.005,
                             .source = Source::kPapersOwnEquation,
                             .why = "(28) with Table 2 settles far more slowly than Fig. 5: the port it has, "
                                    "k_1 times a thousandth of a metre, "
                                    "is a few square micrometres"});
    part.findings.push_back(
        {.item = "Table 2, (32)",
         .quantity = fmt::format("largest pole modulus of (32) at 5 ms, to be stable below, {}", method),
         .paper = 1.0,
         .ours = std::abs(
             identify::regulator_valve::poles(identify::regulator_valve::discretise(rising, 0.005))[0]),
         .expect = Expect::kAtMost,
         .source = Source::kPapersOwnEquation,
         .why = "masses, damping and springs of Table 2 have poles of 395 rad/s, which (32) at t_s = 0.005 s "
                "maps outside the unit "
                "circle: its (30) grows without bound, though (34) and (38) do not"});
  };
  add("LS", kTable2LeastSquares);
  add("PSO", kTable2Swarm);
  return part;
}

}  // namespace plenum::host::reproduce::regulator_valve
