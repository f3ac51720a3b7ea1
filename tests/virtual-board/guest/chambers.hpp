// The eight chambers of the virtual board, as volts at the pins of its converters: commands in, readings out.
//
// Thin-plate valves with the data sheet's figures, one chamber each, whose volumes swing slowly: the rig that
// host-sim/rig simulates (thin_plate_rig), here on the clock of the emulated front end. Sensors: 100 kPa a volt for the
// pressures and the supply; ten volts of a position are twice the chamber's mean volume. A valve without power rests at
// 5 V: its springs centre the spool.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "host-sim/plant/chamber.hpp"

namespace plenum::virtual_board {

class Chambers {
 public:
  static constexpr std::size_t kChambers = 8;
  static constexpr std::size_t kInputs = 2 * kChambers + 1;  ///< pressures, positions, supply

  Chambers();

  /// Time passes [s], > 0, with these commands [V] held.
  void advance(double duration_s, std::span<const double, kChambers> command_V, bool powered);

  /// What the sensors say now [V].
  std::array<double, kInputs> readings_V() const;

 private:
  std::vector<host::plant::ChamberPlant> chamber_;
};

/// The code of a converter that spans `span_V` from `low_V` with 2^16 codes, clipped to them, counted from the one of 0 V.
int code_of(double volts, double low_V, double span_V);

}  // namespace plenum::virtual_board
