// The static grey-box model from a pressure-flow curve.
//
//   [P  Q sqrt(P)  1] (k1 k2 k3)^T = Q sqrt(rho/2) / sqrt(P)      one row a point, least squares        (4.1)
//   k1 P_c + k3 = 0,  k1 P_r + k3 = Q_r sqrt(rho/2) / sqrt(P_r)   exact at both points          (4.7)-(4.8)
//
// P pressure difference [Pa], Q flow [m3/s]. The columns are scaled to unit length before a rank-revealing
// QR.
// Source: "Grey-Box Multi-Port Models of Fluid Power Valves", chapter IV.
#pragma once

#include <span>

#include "host-sim/plant/relief_valve/grey_box.hpp"

namespace plenum::host::identify::relief_valve {

struct StaticPoint {
  double pressure_Pa;  ///< > 0
  double flow_m3_s;    ///< >= 0
};

enum class FlowForce {
  kFitted,   ///< (3.12): k1, k2, k3
  kLeftOut,  ///< (3.15): k1, k3
};

/// (4.1), with k3 held at 0 where least squares would have it above: such a valve cracks at no pressure.
/// Needs as many points of flow above 0 as parameters. Throws std::invalid_argument on points out of range,
/// identify::CannotIdentify when they do not determine the parameters or give k1 <= 0.
plant::relief_valve::StaticGreyBox fit_static(std::span<const StaticPoint> points, double density_kg_m3,
                                              FlowForce flow_force = FlowForce::kFitted);

/// Standard errors of what (4.1) finds, errors of the opening taken as white; 0 for what was held (k2 left out, k3 at 0)
/// and for what follows from it alone, infinite for the maximum pressure of k2 <= 0.
struct StaticError {
  double k1_m2_Pa = 0.0;
  double k2_s_m_sqrtPa = 0.0;
  double k3_m2 = 0.0;
  double cracking_Pa = 0.0;
  double maximum_Pa = 0.0;
};
/// Of `valve`, which fit_static() found on these points. Throws identify::CannotIdentify for no more points than
/// parameters.
StaticError static_error(const plant::relief_valve::StaticGreyBox& valve, std::span<const StaticPoint> points,
                         FlowForce flow_force = FlowForce::kFitted);

/// (4.7)-(4.8): the line of (3.15) through the cracking pressure and one point of flow above 0 and pressure
/// above it.
plant::relief_valve::StaticGreyBox static_through(double cracking_Pa, const StaticPoint& rated,
                                                  double density_kg_m3);

/// Largest |P model - P| / P over the points of flow above 0; NaN where one is.
double worst_pressure_error(const plant::relief_valve::StaticGreyBox& valve,
                            std::span<const StaticPoint> points);

}  // namespace plenum::host::identify::relief_valve
