#include "host-sim/plant/servo/cylinder_rates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::servo {

void validate(const ServoCylinderConfig& config) {
  constexpr double kMost = std::numeric_limits<double>::max();
  validate(config.gas);
  validate(config.friction);
  validate(config.law);
  require_above("cylinder supply_Pa", config.supply_Pa, 0.0);
  require_above("cylinder ambient_Pa", config.ambient_Pa, 0.0);
  require_above("cylinder piston_area_1_m2", config.piston_area_1_m2, 0.0);
  require_above("cylinder piston_area_2_m2", config.piston_area_2_m2, 0.0);
  require_within("cylinder piston_area_2_m2", config.piston_area_2_m2, 0.0, config.piston_area_1_m2);
  require_above("cylinder stroke_m", config.stroke_m, 0.0);
  require_above("cylinder dead_volume_1_m3", config.dead_volume_1_m3, 0.0);
  require_above("cylinder dead_volume_2_m3", config.dead_volume_2_m3, 0.0);
  require_above("cylinder moving_mass_kg", config.moving_mass_kg, 0.0);
  require_finite("cylinder external_force_N", config.external_force_N);
  require_within("cylinder initial_position_m", config.initial_position_m, -0.5 * config.stroke_m,
                 0.5 * config.stroke_m);
  require_above("cylinder initial_pressure_1_Pa", config.initial_pressure_1_Pa, 0.0);
  require_above("cylinder initial_pressure_2_Pa", config.initial_pressure_2_Pa, 0.0);
  require_within("cylinder initial_command_V", config.initial_command_V, -kMost, kMost);
  require_above("cylinder tolerance", config.tolerance, 0.0);
  require_within("cylinder tolerance", config.tolerance, 0.0, 1e-2);
}

ChamberVolume volume_of(const ServoCylinderConfig& config, int chamber, double position_m,
                        double velocity_m_s) {
  const double half = 0.5 * config.stroke_m;
  if (chamber == 0) {
    return {config.dead_volume_1_m3 + config.piston_area_1_m2 * (half + position_m),
            config.piston_area_1_m2 * velocity_m_s};
  }
  return {config.dead_volume_2_m3 + config.piston_area_2_m2 * (half - position_m),
          -config.piston_area_2_m2 * velocity_m_s};
}

CylinderVector initial_state(const ServoCylinderConfig& config) {
  const double x = config.initial_position_m;
  const double T = config.gas.temperature_K;
  CylinderVector y;
  y[kPosition] = x;
  y[kVelocity] = 0.0;
  y[kPressure1] = config.initial_pressure_1_Pa;
  y[kMass1] = mass_of_kg(config.gas, y[kPressure1], volume_of(config, 0, x, 0.0).volume_m3, T);
  y[kPressure2] = config.initial_pressure_2_Pa;
  y[kMass2] = mass_of_kg(config.gas, y[kPressure2], volume_of(config, 1, x, 0.0).volume_m3, T);
  return y;
}

double driving_force_N(const ServoCylinderConfig& config, const CylinderVector& y) {
  return y[kPressure1] * config.piston_area_1_m2 - y[kPressure2] * config.piston_area_2_m2 -
         config.ambient_Pa * config.rod_area_m2() - config.external_force_N;
}

template <class AnyValve>
void gas_rates(const ServoCylinderConfig& config, const std::array<AnyValve, 2>& valves,
               const std::array<typename AnyValve::Opening, 2>& openings, const CylinderVector& y,
               CylinderVector& rates) {
  for (int j = 0; j < 2; ++j) {
    const Eigen::Index pressure = j == 0 ? kPressure1 : kPressure2;
    const auto side = static_cast<std::size_t>(j);
    const ChamberVolume volume = volume_of(config, j, y[kPosition], y[kVelocity]);
    const ChamberState gas{y[pressure], y[pressure + 1]};
    const PortFlows ports =
        valves[side].flows(openings[side], gas.pressure_Pa, config.supply_Pa, config.ambient_Pa);
    // (2) divides by the root of the upstream temperature; the valve took that of supply and ambient
    const double T = temperature_under_K(config.law, config.gas, gas, volume.volume_m3);
    const double leaving = std::sqrt(config.gas.temperature_K / T);
    const Throughflow flow{std::max(ports.inlet_kg_s, 0.0) + std::max(-ports.exhaust_kg_s, 0.0),
                           leaving * (std::max(-ports.inlet_kg_s, 0.0) + std::max(ports.exhaust_kg_s, 0.0))};
    rates[pressure] = pressure_rate_Pa_s(config.law, config.gas, gas, flow, volume);
    rates[pressure + 1] = flow.in_kg_s - flow.out_kg_s;
  }
}

template void gas_rates<ThinPlateValve>(const ServoCylinderConfig&, const std::array<ThinPlateValve, 2>&,
                                        const std::array<ThinPlateValve::Opening, 2>&, const CylinderVector&,
                                        CylinderVector&);
template void gas_rates<MpyeValve>(const ServoCylinderConfig&, const std::array<MpyeValve, 2>&,
                                   const std::array<MpyeValve::Opening, 2>&, const CylinderVector&,
                                   CylinderVector&);

CylinderVector sliding_rates(const ServoCylinderConfig& config, const ValvePair& valves,
                             const Commands& effective_V, double direction, const CylinderVector& y) {
  CylinderVector rates;
  std::visit(
      [&](const auto& pair) {
        gas_rates(config, pair, {pair[0].opening(effective_V[0]), pair[1].opening(effective_V[1])}, y, rates);
      },
      valves);
  rates[kPosition] = y[kVelocity];
  rates[kVelocity] =
      (driving_force_N(config, y) - sliding_friction_N(config.friction, direction, y[kVelocity])) /
      config.moving_mass_kg;
  return rates;
}

double net_flow_kg_s(const ServoCylinderConfig& config, const ValvePair& valves, int chamber,
                     double effective_V, double pressure_Pa) {
  return std::visit(
      [&](const auto& pair) {
        const auto& valve = pair[static_cast<std::size_t>(chamber)];
        const PortFlows ports =
            valve.flows(valve.opening(effective_V), pressure_Pa, config.supply_Pa, config.ambient_Pa);
        return ports.inlet_kg_s - ports.exhaust_kg_s;
      },
      valves);
}

}  // namespace plenum::host::plant::servo
