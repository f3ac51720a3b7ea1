// A two-stage relief valve with the volume upstream of it, by the classical method: a pilot poppet vents the
// chamber behind a spring-loaded main spool, a capillary through the spool fills it.
//
//   V_u/beta P1'  = Q_supply - Q_in,   Q_in = Q_main + Q_cap + A1 x'               continuity, I.A, I.B
//   V_ch/beta P2' = Q_cap + A2 x' - Q_pilot - A_p y'                                             I.C
//   Q_main  = C_dm pi D1 x sin(theta_m) sqrt(2 P1/rho),  Q_pilot = C_dp pi D6 y sin(theta_p) sqrt(2 P2/rho)
//   Q_cap   = pi D4^4 / (128 mu l_cap) (P1 - P2)
//   m_m x'' = P1 A1 - P2 A2 - K_m (x + x0) - F(P1, x; D1, theta_m, C_dm)
//             - (mu A_pr/c + B_m + U(P1; l1, D1, theta_m, C_dm)) x'
//   m_p y'' = P2 A_p - K_p (y + y0) - F(P2, y; D6, theta_p, C_dp) - (B_p + U(P2; l3, D6, theta_p, C_dp)) y'
//   F(P, z; D, theta, C) = phi P C pi D z (sin(2 theta)/2 - 4 C z sin^2(theta)/D)   steady flow force
//   U(P; l, D, theta, C) = l C pi D sin(theta) sqrt(2 rho P)                    unsteady flow force
//
// P1 upstream, P2 chamber pressure over the tank's [Pa]; x, y displacements of spool and pilot [m]; Q flows
// [m3/s]; rho density, mu dynamic viscosity; D1, D6 seats, D4 capillary; A areas; phi 1 as printed (the
// momentum theorem has 2).
// Constraints (VI): 0 <= x <= x_max, 0 <= y <= y_max, P1 >= 0, P2 >= 0; while the pilot is shut P2' = P1'
// (VI.F).
// Assumptions: tank pressure 0; constant density, viscosity, bulk modulus and discharge coefficients;
// turbulent flow at every opening; linear drag; constant volumes. Vanishes (is its static curve) for slow
// supply flow.
// Left out: the part of the unsteady flow force in proportion to P'. The scan of the source does not let its
// formula be read; by the momentum theorem with its second damping length l2 = 0.15 in, rho l2 Q_main P'/(2
// P), it stays below 1 % of the main spring's preload in the source's step response.
// Numerical treatment: below 1 Pa a root is replaced by its chord. See two_stage_run.hpp for the integration.
// Source: "Grey-Box Multi-Port Models of Fluid Power Valves", appendix A.
#pragma once

#include <array>

namespace plenum::host::plant::relief_valve {

/// One metering element: the main spool or the pilot poppet.
struct MeteringElement {
  double seat_diameter_m = 0.0;        ///< D1, D6
  double semi_apical_angle_rad = 0.0;  ///< theta
  double discharge_coefficient = 0.0;  ///< C_d
  double mass_kg = 0.0;
  double spring_N_m = 0.0;
  double preload_m = 0.0;         ///< x0, y0: compression of the spring on the seat
  double travel_m = 0.0;          ///< x_max, y_max
  double damping_length_m = 0.0;  ///< l1, l3
  double drag_N_s_m = 0.0;        ///< mu A_pr / c + B_m, B_p: what does not come from the flow force
};

struct TwoStageConfig {
  MeteringElement main;
  MeteringElement pilot;
  double main_area_m2 = 0.0;              ///< A1, on which P1 acts
  double main_chamber_area_m2 = 0.0;      ///< A2, on which P2 acts
  double pilot_area_m2 = 0.0;             ///< A_p
  double capillary_diameter_m = 0.0;      ///< D4
  double capillary_length_m = 0.0;        ///< l_cap
  double upstream_volume_m3 = 0.0;        ///< V_u
  double chamber_volume_m3 = 0.0;         ///< V_ch
  double bulk_modulus_Pa = 0.0;           ///< beta
  double density_kg_m3 = 0.0;             ///< rho
  double kinematic_viscosity_m2_s = 0.0;  ///< mu / rho
  double flow_force_factor = 1.0;         ///< phi
  bool chamber_follows_while_pilot_shut =
      true;  ///< constraint VI.F; false: the capillary's law holds throughout
};

/// All above 0 but preloads, damping lengths, drags and the factor, which may be 0. Throws
/// std::invalid_argument naming the field.
void validate(const TwoStageConfig& config);

/// The numbers that appendix A prints. What it leaves blank follows from its geometry: A_p = pi/4 D6^2, B_m =
/// B_p = 0, A_pr = pi D3 l1. Where the scan is unsure, D4 is read as 0.01 in and beta as 2.0e5 lbf/in^2.
TwoStageConfig appendix_a_as_printed();
/// The same valve with what settles it near 130 Hz (reproduce's part on fig. 26 says how it was found): the
/// two blanks A_p = 0.020 in^2 and B_p = 0.02 lbf s/in, and D4 read as 0.04 in.
TwoStageConfig appendix_a_settling();

/// P1 [Pa], P2 [Pa], x [m], dx/dt [m/s], y [m], dy/dt [m/s].
using TwoStageState = std::array<double, 6>;
enum TwoStageIndex { kP1, kP2, kX, kV, kY, kU };

/// The physics with its constants worked out once.
class TwoStagePhysics {
 public:
  /// Throws std::invalid_argument as validate().
  explicit TwoStagePhysics(const TwoStageConfig& config);

  double main_flow_m3_s(double P1, double x) const { return main_.flow * x * root(P1); }
  double pilot_flow_m3_s(double P2, double y) const { return pilot_.flow * y * root(P2); }
  double capillary_flow_m3_s(double P1, double P2) const { return capillary_ * (P1 - P2); }
  /// Q_in, what enters the valve [m3/s].
  double valve_flow_m3_s(const TwoStageState& s) const {
    return main_flow_m3_s(s[kP1], s[kX]) + capillary_flow_m3_s(s[kP1], s[kP2]) + config_.main_area_m2 * s[kV];
  }
  /// Force that opens the element [N], all terms together.
  double main_force_N(const TwoStageState& s) const;
  double pilot_force_N(const TwoStageState& s) const;
  /// ds/dt with no constraint in force.
  TwoStageState rate(const TwoStageState& s, double supply_m3_s) const;

  /// What the implicit method needs of d(rate)/ds: rows of P1', P2', x'' and y''.
  struct Slopes {
    double P1_P1, P1_P2, P1_x, P1_v;
    double P2_P1, P2_P2, P2_v, P2_y, P2_u;
    double v_P1, v_P2, v_x, v_v;
    double u_P2, u_y, u_u;
  };
  Slopes slopes(const TwoStageState& s) const;

  const TwoStageConfig& config() const { return config_; }
  double upstream_stiffness_Pa_m3() const { return upstream_; }

 private:
  struct Element {
    explicit Element(const MeteringElement& element, const TwoStageConfig& config);
    double force(double P, double z) const { return P * z * (linear - quadratic * z); }
    double flow;    // m3/s for each m and sqrt(Pa)
    double linear;  // flow force: P z (linear - quadratic z) [N]
    double quadratic;
    double drag;      // [N s/m]
    double unsteady;  // drag for each sqrt(Pa)
    double spring, preload_N, inverse_mass;
  };
  // sqrt(P) and its slope, a chord below 1 Pa
  static double root(double P);
  static double root_slope(double P);

  TwoStageConfig config_;
  Element main_;
  Element pilot_;
  double capillary_;
  double upstream_;
  double chamber_;
};

}  // namespace plenum::host::plant::relief_valve
