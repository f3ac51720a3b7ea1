// The dynamic grey-box model from transients, three ways, as the source goes about it.
//
//   1. algebraic  [P  -a'  1] (k1 k2 k3)^T = a, derivatives by parabolas, least squares: a guess   (4.3)
//   2. free run   all three so that (4.5) of the pressure driven by the flow is least
//   3. two stages k1 and k3 from the static curve, then k2 alone on (4.5)                        (4.6)-(4.8)
//
// a = Q sqrt(rho/(2P)) [m2]; k2 is the lag [s]; with damping over pressure the second column is -a' P0/P, P0
// the mean pressure of the record. Both minimisations are in the logarithms of k1 and the lag and in the
// cracking pressure.
// Source: "Grey-Box Multi-Port Models of Fluid Power Valves", chapter IV.
#pragma once

#include <span>

#include "host-sim/identify/relief_valve/transient.hpp"

namespace plenum::host::identify::relief_valve {

/// 1. Throws identify::CannotIdentify when the samples do not determine the three (too many of them at rest),
/// or when what they determine is no valve: k1 <= 0, lag <= 0, k3 > 0.
plant::relief_valve::GreyBoxConfig fit_algebraic(
    std::span<const Transient> transients, double density_kg_m3,
    plant::relief_valve::Damping damping = plant::relief_valve::Damping::kConstant);

struct DynamicFit {
  plant::relief_valve::GreyBoxConfig valve;
  double performance_index_Pa2_s = 0.0;  ///< (4.5), summed over the transients
  int evaluations = 0;                   ///< of (4.5)
};

/// Standard error of the lag alone [s], the rest of `valve` held and errors of the pressure taken as white; infinite
/// where they do not see it. By central differences.
double lag_error_s(std::span<const Transient> transients, const plant::relief_valve::GreyBoxConfig& valve);

/// 2. From `start`. Throws identify::CannotIdentify when the minimum is not found or the lag runs to a bound.
DynamicFit fit_free_run(std::span<const Transient> transients,
                        const plant::relief_valve::GreyBoxConfig& start);

/// 3. The lag within the two bounds [s]; the rest of `valve` is held. Throws identify::CannotIdentify when
/// the least (4.5) is at a bound, which says that the transients do not determine it.
DynamicFit fit_lag(std::span<const Transient> transients, const plant::relief_valve::GreyBoxConfig& valve,
                   double low_s, double high_s);

}  // namespace plenum::host::identify::relief_valve
