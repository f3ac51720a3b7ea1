// Which set of effects explains the error: every effect alone, then sets by forward, backward and swap steps.
#pragma once

#include <functional>
#include <vector>

#include "host-sim/diagnose/trial.hpp"

namespace plenum::host::diagnose {

/// Of one set.
inline constexpr std::size_t kMostEffects = 3;

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

/// `recalibrated`: that of this scene.
Search search(const Scene& scene, const std::vector<HeldOut>& heldout, Trial recalibrated,
              const SearchOptions& options);

}  // namespace plenum::host::diagnose
