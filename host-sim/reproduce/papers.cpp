#include "host-sim/reproduce/papers.hpp"

#include <array>

#include "host-sim/reproduce/actuators/reproduce_actuators.hpp"
#include "host-sim/reproduce/proportional_valve/reproduce_proportional_valve.hpp"
#include "host-sim/reproduce/regulator_valve/reproduce_regulator_valve.hpp"
#include "host-sim/reproduce/relief_valve/reproduce_relief_valve.hpp"
#include "host-sim/reproduce/servo/reproduce_servo.hpp"

namespace plenum::host::reproduce {

std::span<const Paper> papers() {
  static constexpr std::array<Paper, 5> kPapers{
      {{1, "Modeling and Identification of Pneumatic Actuators", actuators::reproduce_actuators},
       {2,
        "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and "
        "Particle Swarm Optimization Methods",
        regulator_valve::reproduce_regulator_valve},
       {3, "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems",
        servo::reproduce_servo},
       {4, "Grey-Box Multi-Port Models of Fluid Power Valves", relief_valve::reproduce_relief_valve},
       {5, "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve Model",
        proportional_valve::reproduce_proportional_valve}}};
  return kPapers;
}

}  // namespace plenum::host::reproduce
