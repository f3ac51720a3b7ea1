// Sizes that the whole core is built for.
#pragma once

#include <cstddef>

namespace plenum::config {

inline constexpr std::size_t kChambers = 8;  ///< chambers of one board
inline constexpr float kTick_s = 0.01F;      ///< control period [s]

}  // namespace plenum::config
