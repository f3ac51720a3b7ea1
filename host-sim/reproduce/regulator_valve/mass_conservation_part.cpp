// (1)-(9): what flows in and out is what the volume holds.
#include <cmath>

#include "host-sim/plant/regulator_valve/valve.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::regulator_valve {

Part mass_conservation() {
  namespace valve = plant::regulator_valve;
  constexpr double kSample_s = 0.01;
  constexpr int kSamplesHeld = 200;
  constexpr double kGrams = 1e3;
  const valve::ValveConfig bench = valve::bench_valve();
  const double stored_kg_Pa =
      bench.volume_m3 / valve::gamma_R_T_J_kg(bench.gas);  // V/(gamma R T) of (8), (9)
  valve::Valve plant(bench, 0.0, bench.ambient_Pa);
  report::Curve supplied{.name = "through the inlet", .x = {}, .y = {}};
  report::Curve vented{.name = "through the exhaust", .x = {}, .y = {}};
  report::Curve stored{.name = "V/(gamma R T) times the pressure", .x = {}, .y = {}};
  double largest_kg = 0.0;
  for (const double screw_m : {1.5e-3, 2.5e-3, 1.0e-3, 3.0e-3, 0.5e-3}) {
    for (int k = 0; k < kSamplesHeld; ++k) {
      plant.advance(screw_m, kSample_s);
      const valve::ValveState& state = plant.state();
      const double stored_kg = stored_kg_Pa * (state.pressure_Pa - bench.ambient_Pa);
      largest_kg = greater_of(largest_kg, std::abs(stored_kg - (state.supplied_kg - state.vented_kg)));
      supplied.x.push_back(static_cast<double>(supplied.x.size() + 1) * kSample_s);
      supplied.y.push_back(kGrams * state.supplied_kg);
      vented.y.push_back(kGrams * state.vented_kg);
      stored.y.push_back(kGrams * stored_kg);
    }
  }
  vented.x = stored.x = supplied.x;

  // (6) by a difference, of rho = p/(R T) at constant T
  const double RT = bench.gas.specific_gas_constant_J_kg_K() * bench.gas.temperature_K;
  const double p_Pa = 3e5;
  const double dp_Pa = 1.0;
  const double beta_Pa = p_Pa / RT * dp_Pa / ((p_Pa + dp_Pa) / RT - p_Pa / RT);
  return {
      .title = "(1)-(9): mass conservation",
      .text =
          "The simulated valve turned up and down five times: what went through its ports against what (8) "
          "and (9) say that the volume "
          "holds. And the compressibility (6) that (7) is closed with.",
      .findings = {{.item = "(5), (8), (9)",
                    .quantity = "largest distance of V/(gamma R T) times the change of pressure from what "
                                "flowed in less what flowed out, of that supplied",
                    .paper = 0.0,
                    .ours = largest_kg / plant.state().supplied_kg,
                    .tolerance = 1e-9,
                    .why = "the plant loses air"},
                   {.item = "section 3, (6)-(8)",
                    .quantity =
                        "beta/p of (6) for rho = p/(R T) at the constant temperature that section 3 assumes",
                    .paper = bench.gas.kappa,
                    .ours = beta_Pa / p_Pa,
                    .tolerance = 0.05,
                    .source = Source::kPapersOwnEquation,
                    .why = "at constant temperature (6) gives beta = p; (8) and (9) take gamma p, that of an "
                           "adiabatic change, in which the temperature "
                           "moves: the volume then fills 1.4 times as fast. The plant follows (8) and (9)"}},
      .charts = {report::LineChart{.title = "(8), (9): air in, out and held",
                                   .caption = "The volume holds what came in less what went out.",
                                   .y = {"Air", "g"},
                                   .curves = {supplied, vented, stored}}}};
}

}  // namespace plenum::host::reproduce::regulator_valve
