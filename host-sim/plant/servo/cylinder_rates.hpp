// A double-acting cylinder between two valves: the equations, without their integration.
//
//   V_j = V_0j + A_j (L/2 +- x),  Vdot_j = +- A_j xdot           (+ for j = 1)                  (8), (20)
//   Pdot_j by the chamber's law (chamber_law.hpp),  mdot_j = mdot_in,j - mdot_out,j                 (10)-(21)
//   (M + M_p) xddot + F_f + F_d = P_1 A_1 - P_2 A_2 - P_a A_r                                           (22)
//
// x piston position from the middle of the stroke, growing with the volume of chamber 1 [m]; L stroke [m];
// A_j piston area of a side, A_r = A_1 - A_2 area of the rod [m2]; V_0j dead volume with tube and ports [m3];
// P_j, m_j pressure [Pa] and mass of gas [kg]; M load, M_p piston and rod [kg]; F_f friction (friction.hpp),
// F_d external force against +x [N]; P_a ambient pressure [Pa].
//
// Each chamber has a valve port of its own with its own command. One 5/3 valve is two ports with mirrored
// commands: five_three_commands_V(). Flow through a port is that of plant/valve.hpp; gas that leaves a
// chamber does so at the chamber's temperature, whose root (2) divides by.
// Assumptions: rigid piston, no leak past it, supply and ambient constant. Range: |x| <= L/2, P_j > 0.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (2), (8),
// (20)-(22).
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <variant>

#include "host-sim/plant/gas.hpp"
#include "host-sim/plant/servo/chamber_law.hpp"
#include "host-sim/plant/servo/friction.hpp"
#include "host-sim/plant/spool.hpp"
#include "host-sim/plant/valve.hpp"

namespace plenum::host::plant::servo {

/// The ports of chamber 1 and 2, of one kind.
using ValvePair = std::variant<std::array<ThinPlateValve, 2>, std::array<MpyeValve, 2>>;

/// A command for each chamber [V].
using Commands = std::array<double, 2>;

/// One 5/3 valve: chamber 2 sees the command mirrored at 5 V.
inline Commands five_three_commands_V(double command_V) {
  return {command_V, 10.0 - command_V};
}

struct ServoCylinderConfig {
  Gas gas;                             ///< R, T of supply and ambient, k
  double supply_Pa = 700000.0;         ///< absolute
  double ambient_Pa = 101325.0;        ///< P_a, absolute
  double piston_area_1_m2 = 804.2e-6;  ///< A_1: 32 mm bore
  double piston_area_2_m2 = 691.2e-6;  ///< A_2: with a 12 mm rod
  double stroke_m = 0.2;               ///< L
  double dead_volume_1_m3 = 20e-6;     ///< V_01
  double dead_volume_2_m3 = 20e-6;     ///< V_02
  double moving_mass_kg = 5.0;         ///< M + M_p
  Friction friction{30.0, 15.0, 0.02, 80.0};
  ChamberLaw law = Polytropic{1.4};
  std::optional<SpoolConfig> spool;  ///< (1), in both ports; none: the command acts at once
  double external_force_N = 0.0;     ///< F_d, against +x
  double initial_position_m = 0.0;
  double initial_pressure_1_Pa = 101325.0;
  double initial_pressure_2_Pa = 101325.0;
  double initial_command_V = 5.0;  ///< where the spools rest at the start
  double tolerance = 1e-7;         ///< error estimate of a step, of stroke, 1 m/s, 1 bar

  double rod_area_m2() const { return piston_area_1_m2 - piston_area_2_m2; }  ///< A_r
};

/// Throws std::invalid_argument naming the field, its value and its range.
void validate(const ServoCylinderConfig& config);

/// x [m], xdot [m/s], P_1 [Pa], m_1 [kg], P_2 [Pa], m_2 [kg].
using CylinderVector = Eigen::Matrix<double, 6, 1>;
enum CylinderIndex { kPosition, kVelocity, kPressure1, kMass1, kPressure2, kMass2 };

/// V_j and Vdot_j of (20) at a position and a velocity; chamber 0 is the paper's 1.
ChamberVolume volume_of(const ServoCylinderConfig& config, int chamber, double position_m,
                        double velocity_m_s);

/// The state at rest at the configured start, gas at the temperature of `config.gas`.
CylinderVector initial_state(const ServoCylinderConfig& config);

/// P_1 A_1 - P_2 A_2 - P_a A_r - F_d [N]: what pushes the piston before friction answers.
double driving_force_N(const ServoCylinderConfig& config, const CylinderVector& y);

/// d/dt of all but position and velocity, for openings of the two ports; the chambers' volumes move with
/// y[kVelocity]. `AnyValve` is ThinPlateValve or MpyeValve. Shapes as CylinderVector.
template <class AnyValve>
void gas_rates(const ServoCylinderConfig& config, const std::array<AnyValve, 2>& valves,
               const std::array<typename AnyValve::Opening, 2>& openings, const CylinderVector& y,
               CylinderVector& rates);

/// The whole right-hand side of a piston that slides in `direction` (+1, -1; 0: no dry friction, viscous
/// alone) with the spools at `effective_V`.
CylinderVector sliding_rates(const ServoCylinderConfig& config, const ValvePair& valves,
                             const Commands& effective_V, double direction, const CylinderVector& y);

/// Net mass flow into chamber 0 or 1 at a pressure and a command after the spool [kg/s], gas at the
/// temperature of `config.gas`.
double net_flow_kg_s(const ServoCylinderConfig& config, const ValvePair& valves, int chamber,
                     double effective_V, double pressure_Pa);

}  // namespace plenum::host::plant::servo
