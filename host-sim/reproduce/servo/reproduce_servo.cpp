#include "host-sim/reproduce/servo/reproduce_servo.hpp"

#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {

std::vector<Part> reproduce_servo(const Progress& progress) {
  std::vector<Part> parts{spool_part(),    orifice_part(),  bipolynomial_part(),      chambers_part(),
                          cylinder_part(), friction_part(), measured_friction_part(), linear_part(),
                          training_part()};
  if (progress) progress(0.1);
  parts.push_back(free_run_part([&](double share) {
    if (progress) progress(0.1 + 0.9 * share);
  }));
  if (progress) progress(1.0);
  return parts;
}

}  // namespace plenum::host::reproduce::servo
