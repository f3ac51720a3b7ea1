// A set of blind cases on disk, its labels sealed.
//
//   DIR/case-0001/log.csv, heldout.csv, rig.toml   what the machine's user has
//   DIR/case-0001/case.json                        tier, and the SHA-256 of the label: nothing of the cause
//   DIR/labels/case-0001.json                      the truth, with a random salt and the digests of the three files
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "host-sim/blind/blind_case.hpp"

namespace plenum::host::blind {

inline constexpr const char* kLabelSchema = "plenum-blind-label/1";
inline constexpr const char* kCaseSchema = "plenum-blind-case/1";

struct SetRequest {
  std::filesystem::path folder;
  std::size_t cases = 100;
  std::uint64_t seed = 1;
  std::string kind = "all";  ///< one, many, none, unknown, all
  std::string tier = "all";  ///< 1, 2, 3, all
  std::string effect;        ///< empty: in turn
  double seconds = 40.0;
  unsigned threads = 2;
};

/// "case-0001" for 0.
std::string case_name(std::size_t index);

/// What case `index` is made of. Kinds of "all": six tenths one effect, then many, none and unknown; effects and tiers
/// in turn, so that every effect meets every tier. Throws std::invalid_argument for an unknown kind, tier or effect,
/// and for an effect that contradicts the kind.
Recipe recipe_of(const SetRequest& request, std::size_t index);

/// Writes the set; the bytes depend on the request alone, not on `threads`. `done` hears the share that is written.
/// Throws InputError when a file cannot be written or the folder already holds a set.
void write_set(const SetRequest& request, const std::function<void(double)>& done = {});

}  // namespace plenum::host::blind
