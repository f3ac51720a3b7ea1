#include "host-sim/plant/regulator_valve/config.hpp"

#include <limits>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::regulator_valve {

Gas table3_air() {
  Gas gas;
  gas.compressibility = 1.0;
  gas.universal_gas_constant_J_mol_K = 8.314462618;
  gas.molar_mass_kg_mol = gas.universal_gas_constant_J_mol_K / 287.04;
  gas.temperature_K = 298.0;
  gas.kappa = 1.4;
  return gas;
}

double blocked_flow_s_m(const Gas& gas) {
  return thin_plate_constants(gas, 1.0).beta_s_m;
}

double gamma_R_T_J_kg(const Gas& gas) {
  return gas.kappa * gas.specific_gas_constant_J_kg_K() * gas.temperature_K;
}

double overlap_m(const ValveConfig& config) {
  return config.dead_band_m * config.plunger_spring_N_m /
         (config.plunger_spring_N_m + config.spool_spring_N_m);
}

ValveConfig bench_valve(const Behaviour& behaviour) {
  require_above("behaviour slope_Pa_m", behaviour.slope_Pa_m, 0.0);
  require_above("behaviour pressurisation_time_s", behaviour.pressurisation_time_s, 0.0);
  require_above("behaviour exhaustion_time_s", behaviour.exhaustion_time_s, 0.0);
  require_above("behaviour exhaustion_pressure_Pa", behaviour.exhaustion_pressure_Pa, 0.0);
  ValveConfig valve;
  valve.diaphragm_area_m2 = valve.plunger_spring_N_m / behaviour.slope_Pa_m;
  const double filling =
      gamma_R_T_J_kg(valve.gas) * blocked_flow_s_m(valve.gas) / valve.volume_m3;  // [1/(m2 s)]
  valve.inlet_width_m =
      (valve.plunger_spring_N_m + valve.spool_spring_N_m) /
      (filling * valve.supply_Pa * valve.diaphragm_area_m2 * behaviour.pressurisation_time_s);
  valve.exhaust_width_m = valve.plunger_spring_N_m / (filling * behaviour.exhaustion_pressure_Pa *
                                                      valve.diaphragm_area_m2 * behaviour.exhaustion_time_s);
  valve.dead_band_m = behaviour.dead_band_m;
  validate(valve);
  return valve;
}

void validate(const ValveConfig& config) {
  validate(config.gas);
  require_above("regulator valve ambient_Pa", config.ambient_Pa, 0.0);
  require_above("regulator valve supply_Pa", config.supply_Pa, config.ambient_Pa);
  require_above("regulator valve volume_m3", config.volume_m3, 0.0);
  require_above("regulator valve plunger_mass_kg", config.plunger_mass_kg, 0.0);
  require_above("regulator valve spool_mass_kg", config.spool_mass_kg, 0.0);
  require_above("regulator valve plunger_damping_N_s_m", config.plunger_damping_N_s_m, 0.0);
  require_above("regulator valve spool_damping_N_s_m", config.spool_damping_N_s_m, 0.0);
  require_above("regulator valve plunger_spring_N_m", config.plunger_spring_N_m, 0.0);
  require_above("regulator valve spool_spring_N_m", config.spool_spring_N_m, 0.0);
  require_above("regulator valve diaphragm_area_m2", config.diaphragm_area_m2, 0.0);
  require_above("regulator valve inlet_width_m", config.inlet_width_m, 0.0);
  require_above("regulator valve exhaust_width_m", config.exhaust_width_m, 0.0);
  require_within("regulator valve dead_band_m", config.dead_band_m, 0.0, std::numeric_limits<double>::max());
}

}  // namespace plenum::host::plant::regulator_valve
