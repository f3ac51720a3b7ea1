// Sizes that the whole core is built for.
#pragma once

#include <cstddef>
#include <cstdint>

namespace plenum::config {

inline constexpr std::size_t kChambers = 8;           ///< chambers of one board
inline constexpr std::size_t kMostPreview_ticks = 8;  ///< that a set point may come ahead of its time
inline constexpr std::uint32_t kTick_us = 10'000;
inline constexpr float kTick_s = 0.01F;  ///< control period [s]

}  // namespace plenum::config
