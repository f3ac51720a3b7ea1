// Mass flow through one port.
//
// Thin plate:
//   mdot = a phi(p_1, p_2)                                                                            (1a)
//   phi(p_1, p_2) = z(p_1, p_2) for p_1 >= p_2, else -z(p_2, p_1)                                     (1b)
//   z(p_u, p_d) = alpha p_u sqrt(x^(2/kappa) - x^((kappa+1)/kappa)), x = p_d / p_u,  p_u/p_d <= theta
//               = beta p_u                                             beyond (choked)                (1c)
// Ellipse:
//   mdot = A C_d psi_e p_u sqrt(2 / (R T_0))                                                          (B4)
//   psi_e = psi_max                                    r <= b      (choked), r = p_d / p_u            (B6)
//         = psi_max [1 - ((r - b)/(a - b))^2]^beta     b < r < a   (subsonic)
//         = 0                                          r >= a      (not yet cracked)
//   psi_max = (2/(gamma+1))^(1/(gamma-1)) sqrt(gamma/(gamma+1))                                       (B2)
//
// p pressures, absolute [Pa]; a (1a), A effective areas [m2]; phi flow for each m2 [kg/(s m2)]; mdot [kg/s];
// a (B6) cracking ratio, b critical ratio, beta (B6) subsonic index [-]; alpha, beta (1c), theta: gas.hpp.
// (B6) is printed without the square; its own text asks for the ISO form at beta = 1/2, a = 1, which has it.
// Backward flow through an ellipse port was not measured; it is taken odd, as (1b).
//
// Assumptions: perfect gas, isentropic, equal temperatures, quasi-steady.
// Range: p > 0, 0 <= b < a <= 1, beta > 0.
// Vanishes: at p_1 = p_2, at zero area, and for the ellipse wherever r >= a.
//
// Numerical treatment: for kappa = 1.4 the powers are sevenths. With q = x^(1/7) by a cubic start and one
// fourth-order Householder step (no pow, relative error below 2e-14), z = alpha p_u q^5 sqrt(1 - q^2), where
// 1 - q^2 = (1 + q)(1 - x) / (1 + q + ... + q^6) loses no digits as x -> 1. Another kappa takes exp, expm1.
// Within 1e-5 of equal pressures (1 to 7 Pa; for the ellipse, of the cracking ratio) the root is replaced by
// its chord: flow proportional to the pressure difference. The slope, unbounded as printed, becomes finite,
// without which a chamber at rest on its supply has no step length. (A jet of 1 Pa through a millimetre is
// laminar anyway: its Reynolds number is below 100.)
//
// Source: "Modeling and Identification of Pneumatic Actuators" (1)-(1c); B: "Parameter Identification and
// Evaluation of a Proportional Directional Flow Control Valve Model" (2), (4), (6).
#pragma once

#include <algorithm>
#include <cmath>

#include "host-sim/plant/gas.hpp"

namespace plenum::host::plant {

/// A flow from side 1 to side 2 and its slopes with respect to the two pressures.
/// Of a thin plate it is for each square metre [kg/(s m2)], of an ellipse port the whole [kg/s]; slopes are
/// for each Pa.
struct Flux {
  double flow = 0.0;
  double by_first = 0.0;
  double by_second = 0.0;
};

/// Relative distance from equal pressures (or from the cracking ratio) below which the flow is laminar.
inline constexpr double kLaminarBelow = 1e-5;

/// x^(1/7) for 0.528 <= x <= 1; relative error below 2e-14.
inline double seventh_root(double x) {
  // s = x^(-1/7): cubic Chebyshev interpolant (7e-5), then s (1 - e)^(-1/7) with e = 1 - x s^7 expanded to
  // the third order.
  const double s0 =
      1.3417914215325433 + x * (-0.6825335151030851 + x * (0.48550449020479086 - x * 0.14480858119683884));
  const double s2 = s0 * s0;
  const double s4 = s2 * s2;
  const double e = 1.0 - x * s4 * s2 * s0;
  const double s = s0 * (1.0 + e * (1.0 / 7.0 + e * (4.0 / 49.0 + e * (20.0 / 343.0))));
  const double t2 = s * s;
  return x * t2 * t2 * t2;
}

/// The thin-plate flow function (1).
class ThinPlate {
 public:
  explicit ThinPlate(const ThinPlateConstants& constants)
      : constants_(constants),
        inverse_theta_(1.0 / constants.theta),
        sevenths_(std::abs(constants.kappa - 1.4) < 1e-15) {}

  /// phi(p_1, p_2) of (1b) with its slopes; pressures [Pa], both above 0.
  Flux flux(double p1_Pa, double p2_Pa) const {
    if (p1_Pa >= p2_Pa) return downhill(p1_Pa, p2_Pa);
    const Flux back = downhill(p2_Pa, p1_Pa);
    return {-back.flow, -back.by_second, -back.by_first};
  }

  /// phi(p_1, p_2) of (1b) [kg/(s m2)].
  double phi(double p1_Pa, double p2_Pa) const { return flux(p1_Pa, p2_Pa).flow; }

  const ThinPlateConstants& constants() const { return constants_; }

 private:
  // z(p_u, p_d) of (1c) and its slopes: z = alpha p_u G(x), so dz/dp_d = alpha G' and dz/dp_u = alpha (G - x
  // G').
  Flux downhill(double p_u, double p_d) const {
    if (p_d <= p_u * inverse_theta_) return {constants_.beta_s_m * p_u, constants_.beta_s_m, 0.0};
    const double x = p_d / p_u;
    const double alpha = constants_.alpha_s_m;
    const auto [G, dG_dx] = sevenths_ ? subsonic_sevenths(x) : subsonic_general(x);
    return {alpha * p_u * G, alpha * (G - x * dG_dx), alpha * dG_dx};
  }

  struct Subsonic {
    double G;
    double dG_dx;
  };

  // G = q^5 w with q = x^(1/7), w = sqrt(1 - q^2); dG/dx = (5 w^2 - q^2) / (7 q^2 w).
  static Subsonic subsonic_sevenths(double x) {
    const double q = seventh_root(x);
    const double q2 = q * q;
    const double q4 = q2 * q2;
    const double ratio = (1.0 + q) / (q4 * q2 + (1.0 + q) * (1.0 + q2 + q4));  // (1 - q^2) / (1 - x)
    const double w2 = ratio * (1.0 - x);
    const double q5 = q4 * q;
    if (1.0 - x < kLaminarBelow) {  // w by its chord: w^2 = ratio (1 - x)
      const double chord = q5 * std::sqrt(ratio / kLaminarBelow);
      return {chord * (1.0 - x), -chord};
    }
    const double w = std::sqrt(w2);
    return {q5 * w, (5.0 * w2 - q2) / (7.0 * q2 * w)};
  }

  // G = x^(1/kappa) w with w = sqrt(1 - x^((kappa-1)/kappa)).
  Subsonic subsonic_general(double x) const {
    const double kappa = constants_.kappa;
    const double log_x = std::log(x);
    const double w2 = -std::expm1((kappa - 1.0) / kappa * log_x);
    const double y = 1.0 - w2;
    const double root = std::exp(log_x / kappa);
    if (1.0 - x < kLaminarBelow) {
      const double chord = root * std::sqrt((kappa - 1.0) / kappa / kLaminarBelow);
      return {chord * (1.0 - x), -chord};
    }
    const double w = std::sqrt(w2);
    return {root * w, root / (x * kappa) * (w - 0.5 * (kappa - 1.0) * y / w)};
  }

  ThinPlateConstants constants_;
  double inverse_theta_;
  bool sevenths_;
};

/// psi_max of (B2), the choked value of the flow function: 0.484 for gamma = 1.4.
double choked_flow_function(double gamma);

/// The flow function (B6) for one opening: shape and choked flow for each Pa of upstream pressure.
struct EllipsePort {
  double choked_kg_s_Pa = 0.0;    ///< A C_d psi_max sqrt(2 / (R T_0)), from (B4); 0: sealed
  double critical_ratio = 0.528;  ///< b
  double cracking_ratio = 1.0;    ///< a > b
  double subsonic_index = 0.5;    ///< beta > 0

  /// Mass flow [kg/s] from side 1 to side 2 with its slopes; pressures [Pa], both above 0.
  Flux flux(double p1_Pa, double p2_Pa) const {
    if (p1_Pa >= p2_Pa) return downhill(p1_Pa, p2_Pa);
    const Flux back = downhill(p2_Pa, p1_Pa);
    return {-back.flow, -back.by_second, -back.by_first};
  }

 private:
  Flux downhill(double p_u, double p_d) const {
    const double G = choked_kg_s_Pa;
    if (p_d <= critical_ratio * p_u) return {G * p_u, G, 0.0};
    if (G == 0.0 || p_d >= cracking_ratio * p_u) return {};
    const double r = p_d / p_u;
    const double inverse_width = 1.0 / (cracking_ratio - critical_ratio);
    const double xi = (r - critical_ratio) * inverse_width;
    // 1 - xi^2, with 1 - xi = (a - r)/(a - b) taken directly: no digits lost as r -> a
    const double remaining = (cracking_ratio - r) * inverse_width * (1.0 + xi);
    const double d_remaining_dr = -2.0 * xi * inverse_width;
    double shape = 0.0;
    double dpsi_dr = 0.0;
    if (remaining < kLaminarBelow) {
      const double chord = power(kLaminarBelow) / kLaminarBelow;
      shape = chord * remaining;
      dpsi_dr = chord * d_remaining_dr;
    } else {
      shape = power(remaining);
      dpsi_dr = subsonic_index * shape / remaining * d_remaining_dr;
    }
    return {G * p_u * shape, G * (shape - r * dpsi_dr), G * dpsi_dr};
  }

  double power(double y) const {
    if (subsonic_index == 1.0) return y;
    if (subsonic_index == 0.5) return std::sqrt(y);
    return std::pow(y, subsonic_index);
  }
};

}  // namespace plenum::host::plant
