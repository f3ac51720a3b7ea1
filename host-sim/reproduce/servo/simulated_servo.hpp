// The servo that stands for a rig: the paper prints no cylinder, no valve and no recording.
#pragma once

#include <cstdint>

#include "host-sim/identify/servo/cylinder_fit.hpp"

namespace plenum::host::reproduce::servo {

inline constexpr double kPositionNoise_m = 20e-6;  ///< standard deviation of a potentiometer of 200 mm

/// A 32 mm cylinder with a 5 kg load on a thin-plate 5/3 valve with a spool of 65 Hz. Its chambers follow the
/// energy balance (13)-(14) with 1 W/K to the wall, which no model fitted to it has.
identify::servo::ServoRig simulated_servo();

/// A recording of `duration_s` at 10 ms: a proportional position controller follows random set points within
/// +-60 mm, with random steps of up to 0.4 V added so that the command is not the position's echo.
identify::servo::ServoRecord recorded(const identify::servo::ServoRig& rig, double duration_s,
                                      std::uint64_t seed);

}  // namespace plenum::host::reproduce::servo
