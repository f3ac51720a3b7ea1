// What a fit misses of a tick: by how much the error of its free run changes from one row to the next.
//
//   e_k = reading(t_k) - y_k of a free run,   RMS of e_k - e_(k-1)
//
// Near the error of a prediction of the next tick from a known start, but for the share of e that fades within a tick. It asks for no
// state but the pressure: a spool, a hose and what else has memory go on as they are, of which the row before says nothing. It stands
// in for the paper's one-step error ("Modeling and Identification of Pneumatic Actuators", section V.C).
#pragma once

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::identify::chamber {

/// Over the settled rows that are fitted [Pa]. `start`: a record; empty: estimated from the records.
double next_tick_rms_Pa(const Scene& scene, effects::EffectSet on, const effects::Figures& figures,
                        const std::vector<effects::Start>& start = {});

}  // namespace plenum::host::identify::chamber
