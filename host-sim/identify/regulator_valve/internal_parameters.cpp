#include "host-sim/identify/regulator_valve/internal_parameters.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

double divisor(std::string_view name, double value) {
  if (std::isfinite(value) && value != 0.0) return value;
  throw CannotIdentify(
      fmt::format("internal parameters: {} is {}, expected a finite number other than 0", name, value));
}

}  // namespace

InternalParameters internal_parameters(const DiscreteModel& rising, const DiscreteModel& falling,
                                       const SystemConstants& constants) {
  const auto [c1, c2, c3, c4] = read_back(rising);
  const auto [c5, c6, c7, c8] = read_back(falling);
  const double flow = constants.blocked_flow_s_m * constants.gamma_R_T_J_kg / constants.volume_m3;
  const double m_ec = (constants.plunger_damping_N_s_m + constants.spool_damping_N_s_m) / divisor("c_2", c2);
  InternalParameters found;
  found.plunger_mass_kg = constants.plunger_damping_N_s_m / divisor("c_6", c6);
  found.spool_mass_kg = m_ec - found.plunger_mass_kg;
  found.plunger_spring_N_m = divisor("c_7", c7) * found.plunger_mass_kg;
  found.spool_spring_N_m = c3 * m_ec - found.plunger_spring_N_m;
  found.diaphragm_area_m2 = found.plunger_spring_N_m * divisor("c_4", c4) / divisor("c_1", c1);
  found.exhaustion_diaphragm_area_m2 = found.plunger_spring_N_m * c8 / divisor("c_5", c5);
  found.rest_Pa = found.plunger_spring_N_m * constants.rest_screw_m / found.diaphragm_area_m2;
  found.inlet_width_m = c1 * m_ec / (flow * found.plunger_spring_N_m * constants.supply_Pa);
  found.exhaust_width_m = c5 * found.plunger_mass_kg / (flow * found.plunger_spring_N_m * found.rest_Pa);
  return found;
}

}  // namespace plenum::host::identify::regulator_valve
