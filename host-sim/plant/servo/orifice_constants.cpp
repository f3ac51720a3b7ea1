#include "host-sim/plant/servo/orifice_constants.hpp"

#include <cmath>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::servo {

OrificeConstants orifice_constants(double kappa, double gas_constant_J_kg_K) {
  require_above("orifice kappa", kappa, 1.0);
  require_above("orifice gas_constant_J_kg_K", gas_constant_J_kg_K, 0.0);
  const double k = kappa;
  const double R = gas_constant_J_kg_K;
  return {std::sqrt(k / R * std::pow(2.0 / (k + 1.0), (k + 1.0) / (k - 1.0))),
          std::sqrt(2.0 * k / (R * (k - 1.0))), std::pow(2.0 / (k + 1.0), k / (k - 1.0))};
}

double orifice_flow_kg_s(const OrificeConstants& constants, double kappa, double effective_area_m2,
                         double upstream_Pa, double downstream_Pa, double temperature_K) {
  require_above("orifice kappa", kappa, 1.0);
  require_above("orifice upstream_Pa", upstream_Pa, 0.0);
  require_above("orifice downstream_Pa", downstream_Pa, 0.0);
  require_within("orifice downstream_Pa", downstream_Pa, 0.0, upstream_Pa);
  require_above("orifice temperature_K", temperature_K, 0.0);
  const double supply = effective_area_m2 * upstream_Pa / std::sqrt(temperature_K);
  const double ratio = downstream_Pa / upstream_Pa;
  if (ratio <= constants.critical_ratio) return supply * constants.choked;
  return supply * constants.subsonic * std::pow(ratio, 1.0 / kappa) *
         std::sqrt(1.0 - std::pow(ratio, (kappa - 1.0) / kappa));
}

}  // namespace plenum::host::plant::servo
