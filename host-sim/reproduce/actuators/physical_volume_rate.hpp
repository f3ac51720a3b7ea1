// The nine-parameter model with the volume's rate where the physics has it.
//
// (4a) at a held command, its flow written as in (6):
//   pdot = (K(u) (s_0(u) - p) - kappa v' p)/v = (s - p) r
//   r = (K + kappa v')/v,    s = K s_0/(K + kappa v'),    K = c_7 k(u) V
// against (10): r = (c_7 k + c_5 v')/(1 + c_6 v), s = s_0 + c_4 v'. The rate agrees (c_5/c_6 = kappa); the
// steady state is divided, not shifted.
//
// p, s, s_0 [kPa]; r [1/s]; v, V [mL]; v' [mL/s]; K [mL/s]; kappa [1]. s_0 and c_7 k are those of (10) at
// v' = 0 and c_6 = 0: the model of one volume V at rest. Six parameters are free: c_1 to c_3, c_7 to c_9.
// Source: "Modeling and Identification of Pneumatic Actuators" (4a), (6)-(10), III.C.
#pragma once

#include "host-sim/identify/free_run.hpp"
#include "host-sim/identify/tassa9.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::host::reproduce::actuators {

struct PhysicalModel {
  identify::Tassa9 at_rest;  ///< c_4 = c_5 = c_6 = 0
  double volume_mL = 100.0;  ///< V
};

identify::SteadyAndRate steady_and_rate(const PhysicalModel& model, double command_V, double volume_mL,
                                        double volume_rate_mL_s);

/// V.C with this form: least squares of the next pressure on every fourth row of the log, from `start`.
PhysicalModel fit_next_pressure(const trace::Log& log, const PhysicalModel& start);

/// Fig. 13 with this form; as identify::drift().
identify::Drift drift(const trace::Log& log, const PhysicalModel& model, std::size_t starts,
                      double horizon_s);

}  // namespace plenum::host::reproduce::actuators
