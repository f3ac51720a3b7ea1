// The board's grey-box model of a rig that is described: its valve, and those of its effects that a board can answer.
//
//   C = n R T beta a      [m3/s for each m2 of effective area]
//
// n exponent, beta (12) of the choked thin plate with the valve's discharge coefficient, a area: what (4) multiplies with
// p_u psi.
//
// A hose of length L and cross-section A between valve and chamber becomes its air, v_0 += A L, and a dead time,
//
//   d += L/c,   c^2 = kappa R T
//
// what a wave takes to go through it. The board knows no swinging: it waits until a step comes through, and leaves the
// rest to its estimates. (A quarter of the period in which the air of one lump swings against the chamber's is pi/2 times
// as long: with it the closed loop of tests/bench/model_effects.cpp errs by a fifth more.)
//
// A supply that droops by R' for each kg/s droops on a board by R = R'/(n R T) for each Pa m3/s of C phi.
//
// Source: "Modeling and Identification of Pneumatic Actuators" (1)-(4), (12); firmware/control/greybox.hpp.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host-sim/trace/model_json.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::identify {

struct GreyboxModel {
  trace::ModelFile file;
  /// Ids of the rig's effects that the model has no parameters for.
  std::vector<std::string> left_out;
  /// Of effects that it has, figures beyond the board's form: "spool_lag.slew_V_s".
  std::vector<std::string> refinements_left_out;
  /// The rig as the model has it: without these. It keeps sensor_bias, which is calibrated away, and null_drift, where the model's null
  /// stands.
  trace::RigDescription rig;

  /// Both that are left out.
  std::vector<std::string> without() const;
};

/// Carries area_shape, flow_function, volume_error, chamber_leak, dead_time, spool_lag, valve_hysteresis, sensor_lag and
/// supply_droop, without the parameters that refine them but area_shape's bends, a spool's coil and the share of a measured supply, of
/// heat_transfer the exponent, and tube_dynamics as above. A spool's coil, and damping beyond the board's range, become a longer period:
/// it is as late in all as the rig's. A null that drifts stands where it is `at_s` [s] after a log's first row.
/// Throws trace::InputError when an effect is not the catalogue's, or a figure beyond what a board takes.
GreyboxModel greybox_of(const trace::RigDescription& rig, std::optional<unsigned> chamber = std::nullopt,
                        double at_s = 0.0);

}  // namespace plenum::host::identify
