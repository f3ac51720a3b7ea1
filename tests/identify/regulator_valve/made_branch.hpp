// Branches made by a known discrete model, for the tests of what should find it again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/discrete_model.hpp"
#include "host-sim/plant/random.hpp"
#include "host-sim/plant/regulator_valve/testbed.hpp"

namespace plenum::host::identify::regulator_valve::made {

/// Poles 0.95, 0.8 and -0.3, static gain 1.5e8 Pa/m: settles, and every coefficient matters.
inline DiscreteModel known_model() {
  DiscreteModel model{.b_Pa_m = 0.0, .a = {-1.45, 0.235, 0.228}, .sample_s = 0.005};
  model.b_Pa_m = 1.5e8 * model.residue();
  return model;
}

/// Steps of 0.25 mm up and down at random instants, the answer of `model` from rest, and white noise on it.
inline Branch branch_by(const DiscreteModel& model, std::size_t samples, double noise_Pa,
                        std::uint64_t seed) {
  plant::Random random(seed);
  std::vector<double> screw_m(samples, 0.0);
  for (std::size_t k = 4; k < samples; ++k) {
    screw_m[k] = screw_m[k - 1];
    if (random.uniform() < 0.02) screw_m[k] += random.uniform() < 0.5 ? -0.25e-3 : 0.25e-3;
  }
  plant::regulator_valve::Recording recording{
      .sample_s = model.sample_s,
      .screw_m = screw_m,
      .pressure_Pa = free_run(model, screw_m, std::vector<double>(samples, 0.0))};
  for (double& p : recording.pressure_Pa) p += noise_Pa * random.gaussian();
  return zero_mean(recording, 0, samples);
}

}  // namespace plenum::host::identify::regulator_valve::made
