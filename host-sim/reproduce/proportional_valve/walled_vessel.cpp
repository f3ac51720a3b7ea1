#include "host-sim/reproduce/proportional_valve/walled_vessel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host-sim/plant/runge_kutta.hpp"
#include "host-sim/reproduce/proportional_valve/experiment.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using plant::servo::ChamberState;

constexpr double kMostStep_s = 1e-3;
constexpr double kMostMove_Pa = 100.0;  // in a step: where the flow shuts, its rate falls as a root
constexpr plant::servo::ChamberVolume kRigid{kVessel_m3, 0.0};

}  // namespace

WalledVessel::WalledVessel(const plant::MpyeValve& valve, const plant::Gas& gas, double start_Pa,
                           const plant::servo::EnergyBalance& wall)
    : valve_(valve),
      gas_(gas),
      wall_(wall),
      gas_now_{start_Pa, plant::servo::mass_of_kg(gas, start_Pa, kVessel_m3, gas.temperature_K)} {
  plant::servo::validate(wall_);
}

double WalledVessel::temperature_K() const {
  return plant::servo::temperature_of_K(gas_, gas_now_, kVessel_m3);
}

double WalledVessel::fastest_1_s(const plant::MpyeValve::Opening& opening) const {
  const plant::PortFlows ports = valve_.flows(opening, gas_now_.pressure_Pa, kSupply_Pa, kAmbient_Pa);
  const double T = temperature_K();
  const double flow_1_s = gas_.kappa * gas_.specific_gas_constant_J_kg_K() * T / kVessel_m3 *
                          (std::abs(ports.inlet_slope_kg_s_Pa) + std::abs(ports.exhaust_slope_kg_s_Pa));
  const double wall_1_s =
      (gas_.kappa - 1.0) * wall_.wall_conductance_W_K * T / (gas_now_.pressure_Pa * kVessel_m3);
  return flow_1_s + wall_1_s;
}

void WalledVessel::advance(double command_V, double duration_s) {
  using State = std::array<double, 2>;  // pressure, mass
  const plant::MpyeValve::Opening opening = valve_.opening(command_V);
  const auto rate = [&](double, const State& y) -> State {
    const ChamberState s{y[0], y[1]};
    const plant::PortFlows ports = valve_.flows(opening, s.pressure_Pa, kSupply_Pa, kAmbient_Pa);
    const double leaving =
        std::sqrt(gas_.temperature_K / plant::servo::temperature_of_K(gas_, s, kVessel_m3));
    const plant::servo::Throughflow flow{
        std::max(ports.inlet_kg_s, 0.0) + std::max(-ports.exhaust_kg_s, 0.0),
        leaving * (std::max(-ports.inlet_kg_s, 0.0) + std::max(ports.exhaust_kg_s, 0.0))};
    return {plant::servo::pressure_rate_Pa_s(wall_, gas_, s, flow, kRigid), flow.in_kg_s - flow.out_kg_s};
  };
  for (double left_s = duration_s; left_s > 0.0;) {
    const State now{gas_now_.pressure_Pa, gas_now_.mass_kg};
    const double h = std::min(
        {left_s, kMostStep_s, 1.0 / fastest_1_s(opening), kMostMove_Pa / std::abs(rate(0.0, now)[0])});
    const State y = plant::runge_kutta_step(0.0, now, h, rate);
    gas_now_ = {y[0], y[1]};
    left_s -= h;
  }
}

}  // namespace plenum::host::reproduce::proportional_valve
