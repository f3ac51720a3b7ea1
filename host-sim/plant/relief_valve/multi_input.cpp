#include "host-sim/plant/relief_valve/multi_input.hpp"

#include <cmath>
#include <limits>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::relief_valve {
namespace {
constexpr double kAny = std::numeric_limits<double>::max();
}

void validate(const MultiInputConfig& config) {
  require_within("multi-input alpha1_m2", config.alpha1_m2, 0.0, kAny);
  require_above("multi-input alpha2_m2_s_sqrtPa", config.alpha2_m2_s_sqrtPa, 0.0);
  require_within("multi-input alpha3_m3_s_sqrtPa", config.alpha3_m3_s_sqrtPa, 0.0, kAny);
  require_above("multi-input upstream_volume_m3", config.upstream_volume_m3, 0.0);
  require_above("multi-input bulk_modulus_Pa", config.bulk_modulus_Pa, 0.0);
}

double displacement_m(const MultiInputConfig& config, const MultiInputPorts& ports) {
  require_above("multi-input upstream_Pa", ports.upstream_Pa, ports.primary_Pa);
  return ports.primary_flow_m3_s /
         (config.alpha2_m2_s_sqrtPa * std::sqrt(ports.upstream_Pa - ports.primary_Pa));
}

double secondary_flow_m3_s(const MultiInputConfig& config, const MultiInputPorts& ports) {
  require_within("multi-input upstream_Pa", ports.upstream_Pa, ports.secondary_Pa, kAny);
  return config.alpha3_m3_s_sqrtPa * std::sqrt(ports.upstream_Pa - ports.secondary_Pa);
}

double upstream_rate_Pa_s(const MultiInputConfig& config, const MultiInputPorts& ports) {
  require_above("multi-input upstream_Pa", ports.upstream_Pa, ports.primary_Pa);
  const double drop_Pa = ports.upstream_Pa - ports.primary_Pa;
  const double alpha4 = config.upstream_volume_m3 / config.bulk_modulus_Pa;
  const double swept = 0.5 * config.alpha1_m2 / config.alpha2_m2_s_sqrtPa /
                       (drop_Pa * std::sqrt(drop_Pa));  // alpha5 / drop^(3/2)
  if (config.alpha1_m2 > 0.0)
    require_within("multi-input primary_flow_m3_s", ports.primary_flow_m3_s, 0.0, 0.999 * alpha4 / swept);
  const double Q = ports.primary_flow_m3_s;
  return (ports.inflow_m3_s - Q - secondary_flow_m3_s(config, ports) -
          swept * (2.0 * ports.primary_flow_rate_m3_s2 * drop_Pa + ports.primary_rate_Pa_s * Q)) /
         (alpha4 - swept * Q);
}

}  // namespace plenum::host::plant::relief_valve
