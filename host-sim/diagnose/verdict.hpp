// What the errors of a diagnosis say, before any name: README.md has the table.
#pragma once

#include "host-sim/diagnose/gap_report.hpp"

namespace plenum::host::diagnose {

/// Ratios to the noise floor. Clutter that no model holds (quantisation, jitter, ripple) raised the error of perfect
/// models by up to a tenth in simulated recordings.
inline constexpr double kAtFloor = 1.12;
inline constexpr double kNearFloor = 1.3;

/// RMS errors of free runs [Pa]; on held-out rows unless it says otherwise.
struct GapErrors {
  double as_configured_Pa = 0.0;
  double recalibrated_Pa = 0.0;
  double recalibrated_fitted_Pa = 0.0;  ///< on the rows that it was fitted to
  double with_effects_Pa = 0.0;
  double noise_floor_Pa = 0.0;
  double gap_p_value = 0.0;  ///< probability of as large an error were there no gap
};

/// What the set of effects that fits best is: none, one that no other is likely beside, or one that has rivals.
enum class Best { no_effect, alone, has_rivals };

/// Share of what recalibration leaves above the floor, 0 to 1; 0 where it leaves nothing.
double closed_fraction(const GapErrors& errors);

/// Rivals are `ambiguous` where they close the gap: where all of them leave a rest beyond noise, none is the answer.
Verdict verdict_of(const GapErrors& errors, Best best);

}  // namespace plenum::host::diagnose
