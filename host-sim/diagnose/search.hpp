// Which set of effects explains the error: every effect alone, then sets by forward, backward and swap steps.
//
//   evidence = -N/(2 c) ln(S/N) - k/2 ln(N/c)
//
// S sum of squared errors over fitted and held-out rows of the fit to both (joint_squares: figures that the fitted rows leave
// unknown must not decide what the held-out rows say), N their number, c rows for one independent piece of information in
// the error, N/c held within 20 to 200, k variables of the trial: Schwarz's criterion for a free run, whose errors are correlated.
// Differences of evidence are logarithms of odds. The held-out rows have a veto besides: an effect that, fitted without
// them, does not lower their error does not enter.
#pragma once

#include <functional>
#include <vector>

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Fit;
using identify::chamber::Record;
using identify::chamber::Scene;

/// A record with the row from which its errors count as held out.
struct HeldOut {
  Record record;
  std::size_t first = 1;
  /// Whether it continues a fitted record (its start is that record's) or begins anew.
  int continues = -1;
};

/// Of one set.
inline constexpr std::size_t kMostEffects = 3;

/// What a set of effects achieves.
struct Trial {
  effects::EffectSet on = 0;
  Fit fit;
  double heldout_squares = 0.0;
  std::size_t heldout_rows = 0;
  double joint_squares = 0.0;  ///< over fitted and held-out rows of the fit to both
  /// Of figures and warmths: the start pressures, which every trial has, do not count.
  std::size_t variables = 0;

  double heldout_Pa() const;
  bool valid() const;
  /// `correlated_rows`: c above.
  double evidence(double correlated_rows) const;
};

struct Search {
  Trial recalibrated;
  std::vector<Trial> alone;  ///< as the catalogue; on = 0 where the effect was struck out
  Trial best;                ///< recalibrated where no effect is worth its parameters
  /// For each effect of `best` (in the catalogue's order) the sets with another effect in its place, or none.
  std::vector<std::vector<Trial>> rivals;
  double correlated_rows = 1.0;  ///< of the best trial's error
};

struct SearchOptions {
  effects::EffectSet struck = 0;
  unsigned threads = 2;
  double noise_Pa = 100.0;
  std::function<void(double share)> progress;
};

/// The valve's figures fitted, no effect added.
Trial recalibrated(const Scene& scene, const std::vector<HeldOut>& heldout);

/// `recalibrated`: as above, of this scene.
Search search(const Scene& scene, const std::vector<HeldOut>& heldout, Trial recalibrated,
              const SearchOptions& options);

/// The effects of a set, in the catalogue's order.
std::vector<std::size_t> members(effects::EffectSet on);
/// What a set closes of the squares above the noise that a smaller set leaves, 0 to 1; from RMS errors on held-out rows.
double share_of_rest(double with_Pa, double without_Pa, double noise_Pa);
/// The start of a held-out record's run.
effects::Start heldout_start(const Scene& scene, const HeldOut& held, const Fit& fit);
/// Readings of a trial's model over held-out records.
std::vector<double> heldout_reading(const Scene& scene, const HeldOut& held, const Fit& fit);

}  // namespace plenum::host::diagnose
