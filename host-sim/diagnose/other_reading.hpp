// When a log or a rig is better read otherwise than it is written: what the checks of command and reference have in common.
#pragma once

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

/// Of the recalibrated model's error: near the noise nothing is asked.
inline bool errs_far_beyond_noise(const identify::chamber::Scene& scene,
                                  const identify::chamber::Fit& recalibrated) {
  constexpr double kNearNoise = 5.0;
  return recalibrated.rms_Pa() >= kNearNoise * scene.noise_Pa;
}

/// Whether another reading leaves a quarter of the squares at most: a machine's effects change what it leaves by less.
inline bool far_better(double otherwise_Pa, double as_written_Pa) {
  constexpr double kFarBetter = 0.25;
  return otherwise_Pa * otherwise_Pa <= kFarBetter * as_written_Pa * as_written_Pa;
}

}  // namespace plenum::host::diagnose
