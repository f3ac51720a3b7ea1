#include "host-sim/reproduce/servo/simulated_servo.hpp"

#include <algorithm>

#include "host-sim/plant/random.hpp"

namespace plenum::host::reproduce::servo {

using identify::servo::ServoRecord;
using identify::servo::ServoRig;

ServoRig simulated_servo() {
  ServoRig rig;
  rig.cylinder.friction = {30.0, 15.0, 0.02, 80.0};
  rig.cylinder.spool = plant::SpoolConfig{65.0, 0.7};
  rig.cylinder.law = plant::servo::EnergyBalance{1.0, 293.15};
  rig.cylinder.initial_pressure_1_Pa = 340e3;
  rig.cylinder.initial_pressure_2_Pa = 380e3;
  return rig;
}

ServoRecord recorded(const ServoRig& rig, double duration_s, std::uint64_t seed) {
  plant::Random random(seed);
  const plant::ThinPlateValve port(rig.valve, rig.cylinder.gas);
  plant::servo::ServoCylinder cylinder(std::array<plant::ThinPlateValve, 2>{port, port}, rig.cylinder);
  ServoRecord record;
  double set_point_m = 0.0;
  double added_V = 0.0;
  double next_set_point_s = 0.0;
  double next_added_s = 0.0;
  const auto samples = static_cast<std::size_t>(duration_s / record.period_s);
  for (std::size_t k = 0; k < samples; ++k) {
    const double now_s = static_cast<double>(k) * record.period_s;
    if (now_s >= next_set_point_s) {
      set_point_m = random.uniform(-0.06, 0.06);
      next_set_point_s = now_s + random.uniform(0.3, 1.2);
    }
    if (now_s >= next_added_s) {
      added_V = random.uniform(-0.4, 0.4);
      next_added_s = now_s + random.uniform(0.03, 0.15);
    }
    const double gain_V_m = 6.0;
    const double command_V =
        std::clamp(5.0 + gain_V_m * (set_point_m - cylinder.position_m()) + added_V, 3.5, 6.5);
    record.positions_m.push_back(cylinder.position_m() + kPositionNoise_m * random.gaussian());
    record.commands_V.push_back(command_V);
    cylinder.advance(plant::servo::five_three_commands_V(command_V), record.period_s);
  }
  return record;
}

}  // namespace plenum::host::reproduce::servo
