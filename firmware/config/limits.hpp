// Sizes that the whole core is built for.
#pragma once

#include <cstddef>
#include <cstdint>

namespace plenum::config {

inline constexpr std::size_t kChambers = 8;           ///< chambers of one board
inline constexpr std::size_t kMostPreview_ticks = 8;  ///< that a set point may come ahead of its time
/// From a command to its act on the flow: what a regulator can look over.
inline constexpr float kMostValveDelay_ticks = 12.0F;
/// Of a spool's lateness what is made up for as a lag; the rest is delay.
inline constexpr float kMostSpoolLag_ticks = 4.0F;
inline constexpr std::uint32_t kTick_us = 10'000;
inline constexpr float kTick_s = 0.01F;  ///< control period [s]

}  // namespace plenum::config
