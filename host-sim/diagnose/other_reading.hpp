// When a log or a rig is better read otherwise than it is written: what the checks of command and reference have in common.
#pragma once

#include <cmath>
#include <functional>
#include <limits>

#include "host-sim/diagnose/look.hpp"
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

/// RMS error [Pa] of a model of logs as they would read otherwise.
using ErrorOf = std::function<double(const identify::chamber::Scene& otherwise)>;

/// Of the valve's figures, and of the effects that are `on`, fitted to them anew. Nearly all logs are as they are written: a look comes
/// first, and its error is told where it is far from being far less than `as_written_Pa`.
inline ErrorOf fitted_anew(effects::EffectSet on, double as_written_Pa) {
  constexpr double kFar = 2.0;  // of the squares that would tell
  return [=](const identify::chamber::Scene& otherwise) {
    const auto fitted = [on](const identify::chamber::Scene& scene,
                             const identify::chamber::FitOptions& options) {
      return fit(scene, on, scene.nominal, {}, options).rms_Pa();
    };
    if (on == 0) {
      const double seen_Pa = fitted(coarse(otherwise, std::numeric_limits<double>::infinity()),
                                    {.most_iterations = 15, .tolerance = 1e-3});
      if (!far_better(seen_Pa / std::sqrt(kFar), as_written_Pa)) return seen_Pa;
    }
    return fitted(otherwise, {});
  };
}

/// Of the model that was fitted to other logs of the same chamber. A reading of which it errs by more than half again what it errs of
/// those is none, and infinite: the model may be wrong there for a cause of its own, which another reading makes up for by chance.
inline ErrorOf foretold_by(const identify::chamber::Fit& model) {
  return [&model](const identify::chamber::Scene& otherwise) {
    identify::chamber::Score sum;
    for (const identify::chamber::Record& record : otherwise.records) {
      const effects::Start start = estimate_start(otherwise, record, model.on, model.figures);
      const identify::chamber::Score s =
          score(run(otherwise, record, model.on, model.figures, start), record, 1);
      sum.squares += s.squares;
      sum.rows += s.rows;
    }
    constexpr double kAsFitted = 1.5;
    return sum.rms_Pa() <= kAsFitted * model.rms_Pa() ? sum.rms_Pa()
                                                      : std::numeric_limits<double>::infinity();
  };
}

}  // namespace plenum::host::diagnose
