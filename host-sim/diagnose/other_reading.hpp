// When a log or a rig is better read otherwise than it is written: what the checks of command and reference have in common.
#pragma once

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

/// Whether a model's error is near the sensor's noise.
inline bool is_near_noise(double rms_Pa, const identify::chamber::Scene& scene) {
  constexpr double kNearNoise = 5.0;
  return rms_Pa < kNearNoise * scene.noise_Pa;
}

/// Whether another reading leaves a quarter of the squares at most: a machine's effects change what it leaves by less.
inline bool far_better(double otherwise_Pa, double as_written_Pa) {
  constexpr double kFarBetter = 0.25;
  return otherwise_Pa * otherwise_Pa <= kFarBetter * as_written_Pa * as_written_Pa;
}

}  // namespace plenum::host::diagnose
