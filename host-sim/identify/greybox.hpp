// The board's grey-box model of a rig that is described: its valve, and those of its effects that a board can answer.
//
//   C = n R T beta a      [m3/s for each m2 of effective area]
//
// n exponent, beta (12) of the choked thin plate with the valve's discharge coefficient, a area: what (4) multiplies with
// p_u psi. Source: "Modeling and Identification of Pneumatic Actuators" (1)-(4), (12); firmware/control/greybox.hpp.
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
};

/// Carries area_shape, flow_function, volume_error, chamber_leak, dead_time, spool_lag, valve_hysteresis and sensor_lag, without
/// the parameters that refine them. A spool's coil, and damping beyond the board's range, become a longer period: it is as late
/// in all as the rig's. Throws trace::InputError when an effect is not the catalogue's, or a
/// figure beyond what a board takes.
GreyboxModel greybox_of(const trace::RigDescription& rig, std::optional<unsigned> chamber = std::nullopt);

}  // namespace plenum::host::identify
