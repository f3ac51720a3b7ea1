// The prediction of the next tick from the row before it: the paper's one-step error, of the chamber's physics.
//
//   s: reading(t_k; p(t_(k-1)) = s, u_(k-1)) = y_k,   prediction = reading(t_(k+1); s, u_(k-1), u_k)
//
// y_k is a mean over the averaging time before t_k: the pressure at the beginning of its tick is the one from which the model
// reads it. Found by two Newton steps, the reading being almost linear in s. For effects without memory.
// Source: "Modeling and Identification of Pneumatic Actuators", section V.C.
#pragma once

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::identify::chamber {

/// RMS of prediction minus measurement over the fitted rows [Pa].
double next_tick_rms_Pa(const Scene& scene, effects::EffectSet on, const effects::Figures& figures);

/// By how much the error of a free run of the rig as it is described changes from one tick to the next, RMS over the settled rows
/// [Pa]: near the error of the next tick's prediction where the run is near, and for effects with memory, too.
double tick_change_rms_Pa(const Scene& scene);

}  // namespace plenum::host::identify::chamber
