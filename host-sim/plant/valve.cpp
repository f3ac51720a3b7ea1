#include "host-sim/plant/valve.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant {
namespace {

// w smax(x / w) of (3), in units of area; its limit max(x, 0) at w = 0.
double smooth_opening(double area_m2, double transition_m2) {
  return 0.5 * (std::sqrt(area_m2 * area_m2 + transition_m2 * transition_m2) + area_m2);
}

const ThinPlateValveConfig& validated(const ThinPlateValveConfig& config) {
  require_finite("valve open_above_V", config.open_above_V);
  require_finite("valve exhaust_below_V", config.exhaust_below_V);
  require_within("valve inlet_area_per_V_m2", config.inlet_area_per_V_m2, 0.0, 1e-2);
  require_within("valve exhaust_area_per_V_m2", config.exhaust_area_per_V_m2, 0.0, 1e-2);
  require_within("valve inlet_leak_m2", config.inlet_leak_m2, 0.0, 1e-2);
  require_within("valve exhaust_leak_m2", config.exhaust_leak_m2, 0.0, 1e-2);
  require_within("valve transition_m2", config.transition_m2, 0.0, 1e-2);
  return config;
}

// The ports of one table: rows that were not measured (A = 0) take the flow shape of the nearest measured
// row.
std::array<EllipsePort, kMpyeRows> ports_of(const MpyeTable& table, const Gas& gas) {
  const double flow_for_area = kMpyeDischargeCoefficient * choked_flow_function(gas.kappa) *
                               std::sqrt(2.0 / (gas.specific_gas_constant_J_kg_K() * gas.temperature_K));
  const auto first =
      std::find_if(table.begin(), table.end(), [](const MpyeRow& row) { return row.area_m2 > 0.0; });
  const auto last =
      std::find_if(table.rbegin(), table.rend(), [](const MpyeRow& row) { return row.area_m2 > 0.0; });
  const auto first_measured = static_cast<std::size_t>(first - table.begin());
  const auto last_measured = static_cast<std::size_t>(table.rend() - last) - 1;
  std::array<EllipsePort, kMpyeRows> ports;
  for (std::size_t i = 0; i < kMpyeRows; ++i) {
    const MpyeRow& shape = table[std::clamp(i, first_measured, last_measured)];
    ports[i] = {table[i].area_m2 * flow_for_area, shape.critical_ratio, shape.cracking_ratio,
                shape.subsonic_index};
  }
  return ports;
}

EllipsePort interpolated(const std::array<EllipsePort, kMpyeRows>& ports, double table_V) {
  const double place = std::clamp(table_V, 0.0, 10.0) / kMpyeStep_V;
  const std::size_t i = std::min(static_cast<std::size_t>(place), kMpyeRows - 2);
  const double w = place - static_cast<double>(i);
  const EllipsePort& lo = ports[i];
  const EllipsePort& hi = ports[i + 1];
  return {lo.choked_kg_s_Pa + w * (hi.choked_kg_s_Pa - lo.choked_kg_s_Pa),
          lo.critical_ratio + w * (hi.critical_ratio - lo.critical_ratio),
          lo.cracking_ratio + w * (hi.cracking_ratio - lo.cracking_ratio),
          lo.subsonic_index + w * (hi.subsonic_index - lo.subsonic_index)};
}

}  // namespace

ThinPlateValve::ThinPlateValve(const ThinPlateValveConfig& config, const Gas& gas)
    : config_(validated(config)), plate_(thin_plate_constants(gas, config.discharge_coefficient)) {}

ThinPlateValve::Opening ThinPlateValve::opening(double command_V) const {
  const ThinPlateValveConfig& c = config_;
  const double towards_supply = c.inlet_area_per_V_m2 * (command_V - c.open_above_V) - c.inlet_leak_m2;
  const double towards_ambient =
      c.exhaust_area_per_V_m2 * (c.exhaust_below_V - command_V) - c.exhaust_leak_m2;
  return {c.inlet_leak_m2 + smooth_opening(towards_supply, c.transition_m2),
          c.exhaust_leak_m2 + smooth_opening(towards_ambient, c.transition_m2)};
}

MpyeValve::MpyeValve(MpyeChannel channel, const Gas& gas)
    : channel_(channel),
      inlet_(ports_of(channel == MpyeChannel::a ? kMpyeChannelAInlet : kMpyeChannelBInlet, gas)),
      exhaust_(ports_of(channel == MpyeChannel::a ? kMpyeChannelAExhaust : kMpyeChannelBExhaust, gas)) {
  validate(gas);
}

MpyeValve::Opening MpyeValve::opening(double command_V) const {
  const double table_V = channel_ == MpyeChannel::a ? command_V : 10.0 - command_V;
  return {interpolated(inlet_, table_V), interpolated(exhaust_, table_V)};
}

}  // namespace plenum::host::plant
