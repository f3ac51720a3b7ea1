#include "host-sim/diagnose/verdict.hpp"

#include <algorithm>

namespace plenum::host::diagnose {
namespace {

/// Shares of what recalibration left: below the first an effect explains nothing; from the second on it explains all, but
/// for a rest that the form of a true effect may leave, in noise floors.
constexpr double kExplainsSome = 0.35;
constexpr double kExplainsAll = 0.9;
constexpr double kRest = 2.0;

/// From here on an error as large is likely without any gap: then no effect is named, however much less it leaves.
constexpr double kGapUnlikely = 0.05;
/// Of effectless blind logs two in a hundred are below it; each of those of no catalogue is at the least of the test, 0.001.
constexpr double kGapCertain = 0.01;

/// Whether the recalibrated model follows the held-out rows; or else the fitted ones, and the others as well as its
/// figures are known: a log that does not show all of them leaves twice the noise there, and what is left may be no gap.
bool calibrated(const GapErrors& errors) {
  const double floor = errors.noise_floor_Pa;
  return errors.gap_p_value >= kGapCertain || errors.recalibrated_Pa < kNearFloor * floor ||
         (errors.recalibrated_fitted_Pa < kNearFloor * floor &&
          errors.recalibrated_Pa < (kNearFloor + 1.0) * floor);
}

}  // namespace

double closed_fraction(const GapErrors& errors) {
  const double closable = errors.recalibrated_Pa - errors.noise_floor_Pa;
  return closable > 0.0 ? std::clamp((errors.recalibrated_Pa - errors.with_effects_Pa) / closable, 0.0, 1.0)
                        : 0.0;
}

Verdict verdict_of(const GapErrors& errors, Best best) {
  if (errors.as_configured_Pa < kAtFloor * errors.noise_floor_Pa) return Verdict::none;
  if (errors.gap_p_value >= kGapUnlikely) return Verdict::calibration;
  const double closed = closed_fraction(errors);
  if (best == Best::no_effect || closed < kExplainsSome) {
    return calibrated(errors) ? Verdict::calibration : Verdict::unexplained;
  }
  const double rest = errors.with_effects_Pa / errors.noise_floor_Pa;
  if (rest < kNearFloor || (closed >= kExplainsAll && rest < kRest))
    return best == Best::has_rivals ? Verdict::ambiguous : Verdict::explained;
  return Verdict::partly_explained;
}

}  // namespace plenum::host::diagnose
