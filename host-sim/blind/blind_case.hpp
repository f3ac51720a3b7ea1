// One blind case: a machine drawn from the population, its recording, a held-out recording, what its user knows of
// it, and the label.
//
// Population of size 1: supply 400..800 kPa, 0.8..2.2 mm2/V a port, leaks 0.01..0.15 mm2, transition 0.1..0.4 mm2, null
// 4.85..5.15 V, thresholds 0.05..0.25 V apart, 40..300 mL, moving by 20..40 % at 0.1..1.5 Hz (tier 1), noise
// 60..300 Pa a row. The rig's figures are a data sheet's: gains within 15 %, thresholds within 0.05 V, leaks within
// a factor of 3, transition of 2; supply, ambient, temperature, volume and noise are exact.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host-sim/blind/truth.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::blind {

inline constexpr double kHeldoutShare = 0.6;  ///< length of the held-out recording over the recording's

/// What a case is made of.
struct Recipe {
  std::vector<std::string> effects;  ///< ids of departure_kinds(); empty: none
  std::string kind = "none";         ///< one, many, none or unknown: recorded in the label
  int tier = 1;  ///< 1 mixed, volume moving; 2 mixed, volume fixed; 3 a single chirp, fixed
  double seconds = 40.0;
  std::uint64_t seed = 1;
  /// The whole machine's: ports, volume, hoses' cross-sections and vessels are so many times as large, and take as long.
  double size = 1.0;
};

struct Case {
  trace::RigDescription rig;  ///< nominal
  trace::Log log;
  trace::Log heldout;
  Machine machine;               ///< the truth
  nlohmann::ordered_json label;  ///< all but name, salt and the files' digests
};

/// The same recipe gives the same case, bit for bit.
Case make_case(const Recipe& recipe);

}  // namespace plenum::host::blind
