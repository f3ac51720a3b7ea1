// The test bench of the paper: a knob turned by hand in steps, a pressure sensor, samples every 5 ms.
//
// What is recorded is what the paper's experiment knew: the screw as commanded, a step in no time, and the
// noisy gauge pressure. What is not: that a hand takes time for a quarter turn. The paper neglects "the 0.1 s
// delay" of Fig. 5 and reads 0.15 s after it; here the delay is the hand. It turns evenly for 0.18 s, with which the
// bench valve is at 63 % 0.25 s after the step, as in Fig. 5. The paper states neither where its delay comes from
// nor its noise: white, 1 kPa, in the order of a few millivolts of the board (Table 1) on a sensor of some bar over
// a few volts.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods", section 4, Fig. 4-6.
#pragma once

#include <cstdint>
#include <vector>

#include "host-sim/plant/regulator_valve/config.hpp"

namespace plenum::host::plant::regulator_valve {

struct TestbedConfig {
  double sample_s = 0.005;   ///< t_s
  double turn_s = 0.18;      ///< duration of a turn of the knob; at least one sample is taken
  double noise_Pa = 1000.0;  ///< standard deviation
  std::uint64_t seed = 1;    ///< of the noise
};

/// Equal lengths; sample k at k t_s, the screw held from there to the next.
struct Recording {
  double sample_s = 0.0;
  std::vector<double> screw_m;      ///< as commanded
  std::vector<double> pressure_Pa;  ///< gauge, with noise
};

/// One position of the knob: the screw is turned to `screw_m` and left there until `duration_s` is over.
struct Hold {
  double screw_m;
  double duration_s;
};

/// The valve at rest at the first position and `pressure_Pa` (absolute), then every hold in turn. Throws
/// std::invalid_argument for a valve, a bench or a hold out of its range, or no hold.
Recording record(const ValveConfig& valve, const TestbedConfig& bench, double pressure_Pa,
                 const std::vector<Hold>& holds);

/// Up from 0 to `steps` times `step_m` and down again, every position held for `hold_s`: Fig. 6.
std::vector<Hold> staircase(double step_m, int steps, double hold_s);

}  // namespace plenum::host::plant::regulator_valve
