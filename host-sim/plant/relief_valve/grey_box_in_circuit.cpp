#include "host-sim/plant/relief_valve/grey_box_in_circuit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::relief_valve {

GreyBoxInCircuit::GreyBoxInCircuit(const GreyBoxCircuitConfig& config, double flow_m3_s)
    : valve_(config.valve),
      stiffness_Pa_m3_(config.bulk_modulus_Pa / config.upstream_volume_m3),
      root_2_over_density_(std::sqrt(2.0 / config.valve.density_kg_m3)),
      cracks_Pa_(-config.valve.k3_m2 / config.valve.k1_m2_Pa) {
  validate(config.valve);
  require_above("grey box lag_s", config.valve.lag_s, 0.0);
  require_above("grey box upstream_volume_m3", config.upstream_volume_m3, 0.0);
  require_above("grey box bulk_modulus_Pa", config.bulk_modulus_Pa, 0.0);
  require_within("grey box flow_m3_s", flow_m3_s, 0.0, std::numeric_limits<double>::max());
  if (config.valve.damping != Damping::kConstant)
    throw std::invalid_argument("grey box damping: over pressure, expected constant in a circuit");
  if (flow_m3_s > 0.0) {
    pressure_Pa_ = relief_valve::pressure_Pa(
        StaticGreyBox{valve_.k1_m2_Pa, 0.0, valve_.k3_m2, valve_.density_kg_m3}, flow_m3_s);
    opening_m2_ = valve_.k1_m2_Pa * pressure_Pa_ + valve_.k3_m2;
  }
}

double GreyBoxInCircuit::valve_flow_m3_s() const {
  return opening_m2_ * root_2_over_density_ * std::sqrt(std::max(pressure_Pa_, 0.0));
}

GreyBoxInCircuit::Rate GreyBoxInCircuit::rate(double P, double a, double supply_m3_s) const {
  const double through = a * root_2_over_density_ * std::sqrt(std::max(P, 0.0));
  return {stiffness_Pa_m3_ * (supply_m3_s - through),
          (valve_.k1_m2_Pa * P + valve_.k3_m2 - a) / valve_.lag_s};
}

// Returns the time used: up to the cracking pressure, or the whole step.
double GreyBoxInCircuit::advance_shut(double from_m3_s, double slope_m3_s2, double step_s) {
  const auto after = [&](double t) {
    return pressure_Pa_ + stiffness_Pa_m3_ * t * (from_m3_s + 0.5 * slope_m3_s2 * t);
  };
  if (after(step_s) <= cracks_Pa_) {
    pressure_Pa_ = after(step_s);
    return step_s;
  }
  // f t + s t^2 / 2 = missing volume, the root that stays exact as s -> 0
  const double missing_m3 = (cracks_Pa_ - pressure_Pa_) / stiffness_Pa_m3_;
  const double t =
      2.0 * missing_m3 / (from_m3_s + std::sqrt(from_m3_s * from_m3_s + 2.0 * slope_m3_s2 * missing_m3));
  pressure_Pa_ = std::nextafter(cracks_Pa_, std::numeric_limits<double>::infinity());
  return std::min(t, step_s);
}

double GreyBoxInCircuit::advance_open(double from_m3_s, double slope_m3_s2, double step_s) {
  const auto stepped = [&](double h, double& P, double& a) {
    const Rate k1 = rate(P, a, from_m3_s);
    const Rate k2 = rate(P + 0.5 * h * k1.pressure_Pa_s, a + 0.5 * h * k1.opening_m2_s,
                         from_m3_s + 0.5 * h * slope_m3_s2);
    const Rate k3 = rate(P + 0.5 * h * k2.pressure_Pa_s, a + 0.5 * h * k2.opening_m2_s,
                         from_m3_s + 0.5 * h * slope_m3_s2);
    const Rate k4 = rate(P + h * k3.pressure_Pa_s, a + h * k3.opening_m2_s, from_m3_s + h * slope_m3_s2);
    P += h / 6.0 * (k1.pressure_Pa_s + 2.0 * (k2.pressure_Pa_s + k3.pressure_Pa_s) + k4.pressure_Pa_s);
    a += h / 6.0 * (k1.opening_m2_s + 2.0 * (k2.opening_m2_s + k3.opening_m2_s) + k4.opening_m2_s);
  };
  double P = pressure_Pa_;
  double a = opening_m2_;
  stepped(step_s, P, a);
  double used_s = step_s;
  if (a < 0.0) {  // shut on the way: the part of the step that ends there
    double low_s = 0.0;
    for (int i = 0; i < 60; ++i) {
      const double middle_s = 0.5 * (low_s + used_s);
      P = pressure_Pa_;
      a = opening_m2_;
      stepped(middle_s, P, a);
      (a < 0.0 ? used_s : low_s) = middle_s;
    }
    a = 0.0;
  }
  pressure_Pa_ = P;
  opening_m2_ = a;
  return used_s;
}

void GreyBoxInCircuit::advance(double from_m3_s, double to_m3_s, double step_s) {
  const double slope_m3_s2 = (to_m3_s - from_m3_s) / step_s;
  double used_s = 0.0;
  while (used_s < step_s) {
    const double now_m3_s = from_m3_s + slope_m3_s2 * used_s;
    const double left_s = step_s - used_s;
    const double part_s =
        shut() ? advance_shut(now_m3_s, slope_m3_s2, left_s) : advance_open(now_m3_s, slope_m3_s2, left_s);
    if (part_s >= left_s) return;
    used_s += part_s;
  }
}

}  // namespace plenum::host::plant::relief_valve
