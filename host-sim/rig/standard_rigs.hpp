// The rigs that the tools, the tests and the benchmarks simulate.
#pragma once

#include <cstdint>

#include "host-sim/rig/rig.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::rig {

/// The "real" valve of the demonstration: measured MPYE tables, channels A and B in turn, spool lag, moving
/// volumes.
struct MpyeRig {
  unsigned boards = 1;
  unsigned chambers = 8;          ///< of each board
  bool spool = true;              ///< 65 Hz, damping 0.7 (the bandwidth that the tables' paper states)
  double volume_swing = 0.2;      ///< amplitude over mean; 0: the volume stands still
  double supply_Pa = 700'000.0;   ///< absolute, as in the tables' paper
  double ambient_Pa = 100'000.0;  ///< absolute, as in the tables' paper
  std::uint64_t seed = 1;
};

/// Chambers of 0.4 to 1.1 L (what a 3/8 inch valve is made for), each moving at its own 0.2 to 1.0 Hz.
RigConfig mpye_rig(const MpyeRig& wanted);

/// Thin-plate valves with the data-sheet figures of a rig description: the nominal model as a plant, or with the
/// description's effects in every chamber.
struct ThinPlateRig {
  unsigned boards = 1;
  unsigned chambers = 8;
  double volume_m3 = 150e-6;  ///< mean of the first chamber; each further one is a tenth larger
  double volume_swing = 0.2;
  std::uint64_t seed = 1;
};
/// Throws std::invalid_argument as chamber_effects().
RigConfig thin_plate_rig(const trace::RigDescription& description, const ThinPlateRig& wanted);

}  // namespace plenum::host::rig
