// A vessel at the valve's neutral command as a leaking spool would have it: one ordinary orifice from the
// supply and one to the surroundings, both open at once. It rests where the two flows are equal, without any
// cracking.
//
//   pdot = k_in P_s psi(p/P_s) - k_out p psi(P_a/p)                         (7) for both flows together
//
// Both orifices are ideal: b = 0.528, a = 1, beta = 1/2.
#pragma once

#include "host-sim/identify/orifice/vessel.hpp"

namespace plenum::host::reproduce::proportional_valve {

struct TwoLeaks {
  double in_1_s;   ///< choked rate from the supply
  double out_1_s;  ///< choked rate to the surroundings
};

/// The two leaks of a neutral valve that rests at `rest_Pa` and lets `in_1_s` in.
TwoLeaks leaks_resting_at(double rest_Pa, double in_1_s);

/// From 1 bar up (charge) or from 7 bar down (discharge), 1 kHz, without noise.
identify::orifice::VesselRecord run_of(const TwoLeaks& leaks, identify::orifice::Flow flow,
                                       double duration_s);

/// Net rate into the vessel [Pa/s].
double net_rate_Pa_s(const TwoLeaks& leaks, double vessel_Pa);

}  // namespace plenum::host::reproduce::proportional_valve
