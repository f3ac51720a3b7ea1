// When a log or a rig is better read otherwise than it is written: what the checks of command and reference have in common.
#pragma once

#include <functional>

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

/// RMS error [Pa] of a model of logs as they would read otherwise. Called from several threads at once.
using ErrorOf = std::function<double(const identify::chamber::Scene& otherwise)>;

/// Of the valve's figures, and of the effects that are `on`, fitted to them anew. Nearly all logs are as they are written: a look comes
/// first, and its error is told where it is far from being far less than `as_written_Pa`.
ErrorOf fitted_anew(effects::EffectSet on, double as_written_Pa);

/// Of the model that was fitted to other logs of the same chamber. A reading of which it errs by more than half again what it errs of
/// those is none, and infinite: the model may be wrong there for a cause of its own, which another reading makes up for by chance. `model` must
/// outlive it.
ErrorOf foretold_by(const identify::chamber::Fit& model);

}  // namespace plenum::host::diagnose
