#include "host-sim/plant/regulator_valve/linear_model.hpp"

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::regulator_valve {

ThirdOrder linear_pressurisation(const ValveConfig& config) {
  validate(config);
  const double m_ec = config.plunger_mass_kg + config.spool_mass_kg;
  const double filling = config.inlet_width_m * blocked_flow_s_m(config.gas) * config.supply_Pa *
                         gamma_R_T_J_kg(config.gas) / (m_ec * config.volume_m3);
  return {.gain_Pa_m_s3 = filling * config.plunger_spring_N_m,
          .square_1_s = (config.plunger_damping_N_s_m + config.spool_damping_N_s_m) / m_ec,
          .linear_1_s2 = (config.plunger_spring_N_m + config.spool_spring_N_m) / m_ec,
          .constant_1_s3 = filling * config.diaphragm_area_m2};
}

ThirdOrder linear_exhaustion(const ValveConfig& config, double rest_Pa) {
  validate(config);
  require_above("linear_exhaustion rest_Pa", rest_Pa, 0.0);
  const double m_e = config.plunger_mass_kg;
  const double venting = config.exhaust_width_m * blocked_flow_s_m(config.gas) * rest_Pa *
                         gamma_R_T_J_kg(config.gas) / (m_e * config.volume_m3);
  return {.gain_Pa_m_s3 = venting * config.plunger_spring_N_m,
          .square_1_s = config.plunger_damping_N_s_m / m_e,
          .linear_1_s2 = config.plunger_spring_N_m / m_e,
          .constant_1_s3 = venting * config.diaphragm_area_m2};
}

BlockedRange blocked_range(const ValveConfig& config) {
  validate(config);
  const double theta = thin_plate_constants(config.gas, 1.0).theta;
  return {config.ambient_Pa * theta, config.supply_Pa / theta};
}

}  // namespace plenum::host::plant::regulator_valve
