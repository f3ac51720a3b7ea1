// A relief valve seen from its two ports only: pressure difference P and flow Q.
//
//   opening         a = C_d A = Q sqrt(rho / (2 P))                     the equivalent orifice    (3.7)-(3.8)
//   static          a = k1 P + k2 Q sqrt(P) + k3                        with flow forces          (3.12)
//                   a = k1 P + k3                                       without                   (3.15)
//   dynamic         k1 P - lag da/dt + k3 = a,  lag = k2 or k2 / P              (3.14), (4.3), (4.6); (4.4)
//
// P pressure difference [Pa]; Q flow [m3/s]; a effective opening [m2]; rho density [kg/m3]; k1 [m2/Pa], k3
// [m2]; k2 of the static model [s/(m sqrt(Pa))]; lag [s]. Cracking pressure -k3/k1, maximum pressure
// sqrt(rho/2)/k2: the static model holds between the two. The paper writes (3.14) in P, Q and their
// derivatives,
//   (Q' sqrt(P) - Q P' / (2 sqrt(P))) / P = sqrt(2/rho) da/dt,
// so it is a first-order lag of the opening behind its static line: with `a` as the state no input is
// differentiated.
//
// Assumptions: one linear spring, a metering area in proportion to the displacement, a constant discharge
// coefficient, drag in proportion to velocity, no inertia, flow from the pressure to the tank port only.
// Vanishes (is its static model) at lag = 0. Range: P > 0, Q > 0; below the cracking pressure the valve is
// shut and a = 0: opening and shutting are located in time when the pressure drives.
// Numerical treatment: pressure-driven, P linear over an interval, a constant lag is advanced in closed form;
// flow-driven, Q linear, the scalar stiff equation by an L-stable two-stage SDIRK method of second order.
// Source: "Grey-Box Multi-Port Models of Fluid Power Valves", chapters III and IV.
#pragma once

namespace plenum::host::plant::relief_valve {

/// (3.12).
struct StaticGreyBox {
  double k1_m2_Pa = 0.0;
  double k2_s_m_sqrtPa = 0.0;  ///< 0: (3.15), no flow force
  double k3_m2 = 0.0;
  double density_kg_m3 = 865.0;
};

/// k1 > 0, k2 >= 0, k3 <= 0, density > 0. Throws std::invalid_argument naming the field.
void validate(const StaticGreyBox& valve);

/// The lowest pressure at which flow passes, -k3/k1 [Pa].
double cracking_pressure_Pa(const StaticGreyBox& valve);
/// The pressure that the flow approaches as it grows without bound, sqrt(rho/2)/k2 [Pa]; infinite for k2 = 0.
double maximum_pressure_Pa(const StaticGreyBox& valve);
/// Flow [m3/s] at rest; 0 up to the cracking pressure. Throws std::invalid_argument at or above the maximum
/// pressure.
double flow_m3_s(const StaticGreyBox& valve, double pressure_Pa);
/// Pressure difference [Pa] at rest for a flow above 0 [m3/s].
double pressure_Pa(const StaticGreyBox& valve, double flow_m3_s);

/// a = Q sqrt(rho/(2 P)) [m2], (3.7)-(3.8).
double opening_m2(double flow_m3_s, double pressure_Pa, double density_kg_m3);

enum class Damping {
  kConstant,      ///< lag = k2, (3.14), (4.3), (4.6)
  kOverPressure,  ///< lag = k2 / P, (4.4)
};

struct GreyBoxConfig {
  double k1_m2_Pa = 0.0;
  double k3_m2 = 0.0;
  double lag_s = 0.0;  ///< k2; for kOverPressure at `lag_pressure_Pa`: lag = lag_s lag_pressure_Pa / P
  Damping damping = Damping::kConstant;
  double lag_pressure_Pa = 0.0;  ///< > 0 for kOverPressure only
  double density_kg_m3 = 865.0;
};

/// k1 > 0, k3 <= 0, lag >= 0, density > 0. Throws std::invalid_argument naming the field.
void validate(const GreyBoxConfig& config);

/// dP/dt [Pa/s] at (P, Q, dQ/dt) as (3.16) prints it; P, Q > 0, a constant lag.
double pressure_rate_Pa_s(const GreyBoxConfig& config, double pressure_Pa, double flow_m3_s,
                          double flow_rate_m3_s2);
/// dQ/dt [m3/s2] at (P, Q, dP/dt) as (3.17) prints it; P, Q > 0, a constant lag.
double flow_rate_m3_s2(const GreyBoxConfig& config, double pressure_Pa, double flow_m3_s,
                       double pressure_rate_Pa_s);

/// The dynamic model with its opening as the state.
class GreyBoxValve {
 public:
  /// At rest under `pressure_Pa` >= 0. Throws std::invalid_argument as validate().
  GreyBoxValve(const GreyBoxConfig& config, double pressure_Pa);

  /// Moves on with the pressure difference going linearly from one value to the other [Pa, both >= 0];
  /// duration > 0 [s].
  void drive_pressure(double from_Pa, double to_Pa, double duration_s);
  /// Moves on with the flow going linearly from one value to the other [m3/s, both > 0]; duration > 0 [s].
  void drive_flow(double from_m3_s, double to_m3_s, double duration_s);

  double opening_m2() const { return opening_m2_; }
  /// Flow [m3/s] at a pressure difference [Pa].
  double flow_m3_s(double pressure_Pa) const;
  /// Pressure difference [Pa] at a flow [m3/s]; infinite when the valve is shut.
  double pressure_Pa(double flow_m3_s) const;

 private:
  double lag_s(double pressure_Pa) const {
    return config_.damping == Damping::kConstant ? config_.lag_s
                                                 : config_.lag_s * config_.lag_pressure_Pa / pressure_Pa;
  }
  double implicit_stage(double known_m2, double weight_s, double flow_m3_s, double guess_m2) const;

  GreyBoxConfig config_;
  double opening_m2_ = 0.0;
};

}  // namespace plenum::host::plant::relief_valve
