// The plant's piston, with its stick and slip, taken through a measured motion: what friction it then shows.
//
//   M xddot = K (x_m - x) + D (v_m - xdot) - F_f                                              (22), (23)
//   measured: F - A p - F_0
//
// x piston of plant/servo/cylinder [m]; v_m measured velocity, the slope of a straight line through 0.1 s on
// each side, and x_m its integral [m/s, m]; F_f friction of the plant: (23) in motion, at rest what the coupling
// asks for up to breakaway [N]; F bench force, A p the chamber's part in it, F_0 zero of the force cell [N].
// K = 1 MN/m, D, M = 1 kg are ours: a coupling that gives way by 10 um at most, and follows within 5 ms.
// The plant's own chambers are shut and so large that they hold no force.
#pragma once

#include <cstdint>
#include <vector>

#include "host-sim/plant/servo/friction.hpp"
#include "host-sim/reproduce/servo/measured_friction.hpp"

namespace plenum::host::reproduce::servo {

/// The bench, as the fit of the records gives it.
struct PullingBench {
  double area_m2;
  double zero_N;
};

/// Columns of equal length.
struct DrivenFriction {
  std::vector<double> time_s;  ///< from the first sample
  std::vector<double> measured_N;
  std::vector<double> plant_N;
  double stuck_s = 0.0;  ///< how long the plant's piston rested, to 0.1 ms

  /// RMS of plant less measured [N].
  double rms_N() const;
  /// Greatest less least of measured [N].
  double span_N() const;
};
DrivenFriction driven_friction(const std::vector<PulledSample>& samples, const PullingBench& bench,
                               const plant::servo::Friction& friction);

}  // namespace plenum::host::reproduce::servo
