#include "host-sim/diagnose/other_reading.hpp"

#include <cmath>
#include <limits>

#include "host-sim/diagnose/look.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Fit;
using identify::chamber::FitOptions;
using identify::chamber::Record;
using identify::chamber::Scene;
using identify::chamber::Score;

ErrorOf fitted_anew(effects::EffectSet on, double as_written_Pa) {
  constexpr double kFar = 2.0;  // of the squares that would tell
  return [=](const Scene& otherwise) {
    const auto fitted = [on](const Scene& scene, const FitOptions& options) {
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

ErrorOf foretold_by(const Fit& model) {
  return [&model](const Scene& otherwise) {
    Score sum;
    for (const Record& record : otherwise.records) {
      const effects::Start start = estimate_start(otherwise, record, model.on, model.figures);
      const Score s = score(run(otherwise, record, model.on, model.figures, start), record, 1);
      sum.squares += s.squares;
      sum.rows += s.rows;
    }
    constexpr double kAsFitted = 1.5;
    return sum.rms_Pa() <= kAsFitted * model.rms_Pa() ? sum.rms_Pa()
                                                      : std::numeric_limits<double>::infinity();
  };
}

}  // namespace plenum::host::diagnose
