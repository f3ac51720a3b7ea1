// What the identification takes from a staircase of steps: its rising and its falling branch within a range of
// pressures, each with zero mean, and the dead band between them.
//
// A plateau is a position of the screw held; it has settled to the mean of its last quarter. A branch goes from
// a little before the end of its first plateau within the range to the end of its last, in one direction of the
// screw.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods", section 4: range (11), "zero mean" before (33), Fig. 6.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/plant/regulator_valve/testbed.hpp"

namespace plenum::host::identify::regulator_valve {

/// Gauge pressures, the defaults those of (11).
struct PressureRange {
  double low_Pa = 0.894e5;
  double high_Pa = 3.224e5;
};

enum class Direction { kRising, kFalling };

struct Plateau {
  std::size_t first = 0;  ///< sample
  std::size_t end = 0;    ///< one past its last
  double screw_m = 0.0;
  double settled_Pa = 0.0;
};

/// One stretch of a recording, as deviations from its means.
struct Branch {
  double sample_s = 0.0;
  std::size_t first = 0;  ///< sample of the recording at which it begins
  double mean_screw_m = 0.0;
  double mean_pressure_Pa = 0.0;
  std::vector<double> screw_m;
  std::vector<double> pressure_Pa;
};

/// Throws std::invalid_argument for columns of unequal lengths, a sample that is not finite, and a sample time
/// not above 0.
void validate(const Branch& branch);

/// Settled pressures over the screw, rising and falling, as two straight lines.
struct DeadBand {
  double width_m = 0.0;         ///< between the lines at the middle of the range
  double rising_start_m = 0.0;  ///< where the rising line leaves 0 Pa: the dead band of the first turns
  double rising_slope_Pa_m = 0.0;
  double falling_slope_Pa_m = 0.0;
};

/// Throws std::invalid_argument for a recording that is empty or of unequal lengths.
std::vector<Plateau> plateaus(const plant::regulator_valve::Recording& recording);

/// Samples [first, end) of a recording with their means taken off. Throws std::invalid_argument where they are
/// none.
Branch zero_mean(const plant::regulator_valve::Recording& recording, std::size_t first, std::size_t end);

/// Throws CannotIdentify where fewer than two plateaus of that direction lie in the range, std::invalid_argument
/// as plateaus() and for a sample time not above 0.
Branch branch_of(const plant::regulator_valve::Recording& recording, Direction direction,
                 const PressureRange& range = {});

/// Throws as branch_of().
DeadBand measure_dead_band(const plant::regulator_valve::Recording& recording,
                           const PressureRange& range = {});

}  // namespace plenum::host::identify::regulator_valve
