// Commands that excite a blind machine: scripted segments, each with a little feedback from the reading, so that
// the pressure ranges over its span instead of resting at supply or ambient.
//
// Mixed (tiers 1 and 2), in shares of the recording:
//   fill and dump   0.26  full strokes, sealed holds of 2 s near the top and near a third
//   steps           0.22  random steps of mixed size, several on one side before the side changes, with reversals
//   targets         0.16  a regulator (proportional, integral) on random targets, 3 to 7 V
//   chirp           0.14  two amplitudes
//   staircase       0.12  small openings up and down on one side, to equalisation with supply, then with ambient
//   repeat          0.10  one scripted stroke pattern from ambient, twice
// Single chirp (tier 3): one amplitude, with a slow pull to the middle of the span.
// Holds are capped to fit short recordings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host-sim/blind/random.hpp"
#include "host-sim/blind/truth.hpp"

namespace plenum::host::blind {

enum class Excitation { kMixed, kChirp };

struct ExcitationSetting {
  Excitation kind = Excitation::kMixed;
  std::size_t rows = 4000;
  double period_s = 0.01;
  double supply_Pa = 700e3;
  double ambient_Pa = 101325.0;
  double null_V = 5.0;       ///< middle between the nominal thresholds
  double half_gap_V = 0.08;  ///< half the distance between them
  double fill_s = 0.1;       ///< time constant of filling through one volt of opening
};

/// A driver for simulate(); it holds its own state and serves one run.
Driver excite(const ExcitationSetting& setting, std::uint64_t seed);

}  // namespace plenum::host::blind
