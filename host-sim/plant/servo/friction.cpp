#include "host-sim/plant/servo/friction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::servo {

void validate(const Friction& friction) {
  constexpr double kMost = std::numeric_limits<double>::max();
  require_within("friction coulomb_N", friction.coulomb_N, 0.0, kMost);
  require_within("friction stribeck_N", friction.stribeck_N, 0.0, kMost);
  require_above("friction stribeck_velocity_m_s", friction.stribeck_velocity_m_s, 0.0);
  require_within("friction viscous_N_s_m", friction.viscous_N_s_m, 0.0, kMost);
  require_above("friction stribeck_exponent", friction.stribeck_exponent, 0.0);
}

double sliding_friction_N(const Friction& friction, double direction, double velocity_m_s) {
  // an integrator's trial may overshoot into the other direction: no further than to rest
  const double ratio = std::max(direction * velocity_m_s, 0.0) / friction.stribeck_velocity_m_s;
  const double power =
      friction.stribeck_exponent == 1.0 ? ratio : std::pow(ratio, friction.stribeck_exponent);
  return direction * (friction.coulomb_N + friction.stribeck_N * std::exp(-power)) +
         friction.viscous_N_s_m * velocity_m_s;
}

}  // namespace plenum::host::plant::servo
