// The paper's test rig (its Fig. 4 and 5), simulated: one channel of the MPYE valve, a 0.4 L vessel, a supply
// of 7 bar absolute, two pressure transducers and a 16-bit card at 1 kHz.
//
// A square wave alternates between a set point and the fully open opposite. The set point is held until the
// vessel rests; the other half cycle starts it from the same pressure again. Ten cycles are recorded and
// averaged. The cycles of a settled square wave differ by their noise alone, so that one is integrated and
// ten noises drawn.
//
// Stated by the paper: volume, supply, transducer 9.9 mV/kPa, 16 bits, 1 kHz, 10 cycles. Not stated, and
// ours: +-10 V range of the card, white noise of 2 mV (0.2 kPa), periodic noise of 1 mV at 100 Hz with a
// phase of its own in every cycle, constant supply, ambient at the paper's P_a. The vessel's gas obeys (7) with
// the alpha of the direction, as the paper's model of it does; or it exchanges heat with a wall
// (walled_vessel.hpp), which leaves alpha to the gas.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host-sim/identify/orifice/vessel.hpp"
#include "host-sim/plant/mpye_tables.hpp"
#include "host-sim/plant/servo/chamber_law.hpp"
#include "host-sim/plant/spool.hpp"
#include "host-sim/plant/valve.hpp"

namespace plenum::host::reproduce::proportional_valve {

inline constexpr double kVessel_m3 = 0.4e-3;
inline constexpr double kSupply_Pa = 7e5;
inline constexpr double kAmbient_Pa = 1e5;
inline constexpr double kSample_s = 1e-3;
inline constexpr std::size_t kCycles = 10;
inline constexpr double kMillivoltPerKilopascal = 9.9;

/// One of the four series: a channel and a direction, with the table that it identified.
struct Series {
  plant::MpyeChannel channel;
  identify::orifice::Flow flow;
  const plant::MpyeTable* table;
  int number;  ///< of the table in the paper
};
const std::vector<Series>& all_series();

/// A row of `table` that was measured.
struct Row {
  double command_V;  ///< as the table prints it
  plant::MpyeRow truth;
};
std::vector<Row> measured_rows(const Series& series);

struct RigOptions {
  std::optional<plant::SpoolConfig> spool{};  ///< none: the paper's assumption
  /// None: (7) with the paper's alpha. With a wall the spool follows at once.
  std::optional<plant::servo::EnergyBalance> wall{};
  double white_V = 2e-3;
  double periodic_V = 1e-3;
  std::uint64_t seed = 5;
  double most_s = 60.0;  ///< a set point is held no longer than this
};

/// What the rig records of one set point, averaged over the cycles.
struct Experiment {
  identify::orifice::VesselRecord record;  ///< from the switch to the set point to rest
  std::vector<double> vessel_truth_Pa;     ///< without noise, at the same times
};
/// Throws std::invalid_argument where `options` ask for a wall and a spool.
Experiment measure(const Series& series, double command_V, const RigOptions& options = {});

/// The same vessel under 5 + 2.5 sin(2 pi 2 t) V, one settled period.
struct SineExperiment {
  std::vector<double> time_s;
  std::vector<double> command_V;
  std::vector<double> vessel_Pa;  ///< averaged over the cycles
  std::vector<double> supply_Pa;
};
SineExperiment measure_sine(plant::MpyeChannel channel, const RigOptions& options = {});

/// The paper's vessel: V of Table 1, alpha of the direction, C_d.
identify::orifice::Vessel papers_vessel(identify::orifice::Flow flow);

}  // namespace plenum::host::reproduce::proportional_valve
