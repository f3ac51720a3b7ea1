// Free runs of the chamber over a log: eight sets of figures at once, fed with command and volume only.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "host-sim/effects/catalogue.hpp"
#include "host-sim/effects/chamber_model.hpp"

namespace plenum::host::effects {

/// What drives a run: the command held from each row to the next, and the volume at the ends of the model's steps,
/// of which the first of each tick is at its row.
struct Drive {
  std::vector<double> command_V;
  std::vector<double> volume_m3;  ///< (rows - 1) * steps + 1
  Timing timing;
  std::vector<double> supply_Pa{};  ///< as logged, in the mean of each tick from its row on; or none
};

/// From volumes at the rows, 2 at least, and as many commands. Between rows the volume follows the parabola whose
/// curvature is the mean of those at both rows: a straight line would err by 1e-4 of a volume swinging at 1 Hz.
/// `supply_Pa`: at the rows, or none.
Drive make_drive(std::span<const double> command_V, std::span<const double> volume_m3, const Timing& timing,
                 std::span<const double> supply_Pa = {});

inline constexpr std::size_t kOwnNull = 2 + kNullKnots;

/// What a log has of its own: the gas at its first row, and the way of the null.
struct Start {
  double pressure_Pa = 0.0;
  /// What the pressure loses as the gas comes to the wall's temperature at its volume: p - m R T_0/v. Only
  /// heat_transfer asks for it.
  double warmth_Pa = 0.0;
  /// Added to both thresholds, to the drift at 60 s and to each W of null_drift.
  std::array<double, kOwnNull> null_V{};
};

/// One of the chambers that run side by side.
struct Run {
  Figures figures;
  Start start;
};

/// Readings of `runs` (1 to kLanes), row by row, lane by lane: readings[row * kLanes + lane]; row 0 is the start's pressure.
/// The run has as many rows as `readings` has room for, at most those of `drive`. Lanes beyond `runs` repeat the first. Takes the widest instructions that
/// the processor has.
void free_run(const Surroundings& around, const Drive& drive, EffectSet on, std::span<const Run> runs,
              std::span<double> readings);

}  // namespace plenum::host::effects
