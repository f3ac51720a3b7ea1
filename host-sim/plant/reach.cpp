#include "host-sim/plant/reach.hpp"

#include <algorithm>
#include <limits>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant {
namespace {

constexpr double kScan_s = 1e-3;
constexpr double kGiveUp_s = 60.0;

// The place in (low, high) where the falling predicate turns from true to false.
template <class Predicate>
double turning_point(double low, double high, double within, Predicate holds) {
  while (high - low > within) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (holds(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double mass_flow_kg_s(const Valve& valve, double pressure_Pa, double command_V, double supply_Pa,
                      double ambient_Pa) {
  return std::visit(
      [&](const auto& any) {
        const PortFlows m = any.flows(any.opening(command_V), pressure_Pa, supply_Pa, ambient_Pa);
        return m.inlet_kg_s - m.exhaust_kg_s;
      },
      valve);
}

RestBand rest_band(const Valve& valve, double command_V, double supply_Pa, double ambient_Pa) {
  const auto flow = [&](double p) { return mass_flow_kg_s(valve, p, command_V, supply_Pa, ambient_Pa); };
  const double low = 0.5 * ambient_Pa;
  const double high = 2.0 * supply_Pa;
  const double within = 1e-9 * supply_Pa;
  return {turning_point(low, high, within, [&](double p) { return flow(p) > 0.0; }),
          turning_point(low, high, within, [&](double p) { return flow(p) >= 0.0; })};
}

double steady_state_Pa(const Valve& valve, double command_V, double supply_Pa, double ambient_Pa) {
  const RestBand band = rest_band(valve, command_V, supply_Pa, ambient_Pa);
  return std::clamp(0.5 * (supply_Pa + ambient_Pa), band.low_Pa, std::max(band.low_Pa, band.high_Pa));
}

double bang_bang_time_s(ChamberPlant start, double target_Pa, double low_V, double high_V) {
  require_above("bang-bang target_Pa", target_Pa, 0.0);
  const bool up = target_Pa > start.pressure_Pa();
  if (target_Pa == start.pressure_Pa()) return 0.0;
  const double command_V = up ? high_V : low_V;
  const auto short_of = [&](double p) { return up ? p < target_Pa : p > target_Pa; };
  const double begin_s = start.time_s();
  while (start.time_s() - begin_s < kGiveUp_s) {
    ChamberPlant next = start;
    if (short_of(next.advance(command_V, kScan_s).end_Pa)) {
      start = next;
      continue;
    }
    const double within = turning_point(0.0, kScan_s, 1e-9, [&](double t) {
      ChamberPlant part = start;
      return short_of(part.advance(command_V, t).end_Pa);
    });
    return start.time_s() - begin_s + within;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace plenum::host::plant
