#include "host-sim/plant/servo/chamber_law.hpp"

#include <cmath>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::servo {
namespace {

constexpr double kMostExponent = 2.0;

struct Checks {
  void operator()(const Polytropic& law) const {
    require_within("chamber law polytropic index", law.index, 1.0, kMostExponent);
  }
  void operator()(const MixedExponents& law) const {
    require_within("chamber law exponent entering", law.entering, 1.0, kMostExponent);
    require_within("chamber law exponent leaving", law.leaving, 1.0, kMostExponent);
    require_within("chamber law exponent compression", law.compression, 1.0, kMostExponent);
  }
  void operator()(const EnergyBalance& law) const {
    require_finite("chamber law wall_conductance_W_K", law.wall_conductance_W_K);
    require_within("chamber law wall_conductance_W_K", law.wall_conductance_W_K, 0.0, 1e6);
    require_above("chamber law wall_temperature_K", law.wall_temperature_K, 0.0);
  }
};

}  // namespace

void validate(const ChamberLaw& law) {
  std::visit(Checks{}, law);
}

double mass_of_kg(const Gas& gas, double pressure_Pa, double volume_m3, double temperature_K) {
  return pressure_Pa * volume_m3 / (gas.specific_gas_constant_J_kg_K() * temperature_K);
}

double temperature_of_K(const Gas& gas, const ChamberState& state, double volume_m3) {
  return state.pressure_Pa * volume_m3 / (state.mass_kg * gas.specific_gas_constant_J_kg_K());
}

double temperature_under_K(const ChamberLaw& law, const Gas& gas, const ChamberState& state,
                           double volume_m3) {
  if (std::holds_alternative<MixedExponents>(law)) return gas.temperature_K;
  return temperature_of_K(gas, state, volume_m3);
}

double pressure_rate_Pa_s(const ChamberLaw& law, const Gas& gas, const ChamberState& state,
                          const Throughflow& flow, const ChamberVolume& volume) {
  const double R = gas.specific_gas_constant_J_kg_K();
  const double T = temperature_under_K(law, gas, state, volume.volume_m3);
  const double P = state.pressure_Pa;
  const double V = volume.volume_m3;
  const double V_dot = volume.rate_m3_s;
  if (const auto* polytropic = std::get_if<Polytropic>(&law)) {
    return polytropic->index / V * (R * T * (flow.in_kg_s - flow.out_kg_s) - P * V_dot);
  }
  if (const auto* mixed = std::get_if<MixedExponents>(&law)) {
    return R * T / V * (mixed->entering * flow.in_kg_s - mixed->leaving * flow.out_kg_s) -
           mixed->compression * P / V * V_dot;
  }
  const auto& balance = std::get<EnergyBalance>(law);
  const double k = gas.kappa;
  const double heat_W = balance.wall_conductance_W_K * (balance.wall_temperature_K - T);
  const double enthalpy_W =
      k * R / (k - 1.0) * (flow.in_kg_s * gas.temperature_K - flow.out_kg_s * T);  // k C_v T mdot of (13)
  return ((k - 1.0) * (heat_W + enthalpy_W) - k * P * V_dot) / V;
}

double polytropic_rate_Pa_s(const Gas& gas, double index, const ChamberState& state, double start_pressure_Pa,
                            double start_temperature_K, const Throughflow& flow,
                            const ChamberVolume& volume) {
  const double n = index;
  const double R = gas.specific_gas_constant_J_kg_K();
  const double P = state.pressure_Pa;
  return n * R * start_temperature_K / (volume.volume_m3 * std::pow(P / start_pressure_Pa, 1.0 / n - 1.0)) *
             (flow.in_kg_s - flow.out_kg_s) -
         n * P * volume.rate_m3_s / volume.volume_m3;
}

double isothermal_heat_W(const Gas& gas, const ChamberState& state, const Throughflow& flow,
                         const ChamberVolume& volume) {
  const double P_rho =
      gas.specific_gas_constant_J_kg_K() * temperature_of_K(gas, state, volume.volume_m3);  // P / rho
  return state.pressure_Pa * volume.rate_m3_s - P_rho * (flow.in_kg_s - flow.out_kg_s);
}

}  // namespace plenum::host::plant::servo
