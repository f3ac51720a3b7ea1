// The pressure of a chamber with a moving volume, fed and vented by a valve.
//
//   pdot = (R T / v) (n_c mdot_c - n_r mdot_r) - kappa (vdot / v) p (4a), (B7)
//
// p pressure, absolute [Pa]; v volume [m3]; mdot_c flow in from the supply, mdot_r flow out to ambient
// [kg/s]; R gas constant [J/(kg K)] (gas.hpp); T temperature [K]; n exponent of the flow term by direction:
// kappa (4a), or alpha_i of the measured valve (B7), which then meets the adiabatic compression term of (4a).
// Assumptions: perfect gas at one temperature, uniform pressure in the chamber, constant supply and ambient
// within an interval. Range: p > 0, v > 0. Vanishes: pdot = 0 with both ports shut and the volume at rest.
//
// Numerical treatment: exponential integration, third order, with error control inside the interval. Over a
// step h from (t, p) write pdot = F + J (P - p) + D(tau, P), F and J = d pdot / d p at its start. The linear
// part, which is all there is while both ports are choked and the volume is at rest, is integrated in closed
// form; the rest D (curvature of the flow, motion of volume and spool) is interpolated by a parabola through
// tau = 0, h/2, h, and integrated exactly against it:
//   P_2 = p + h/2 phi_1(z/2) F                                  D_2 = D(h/2, P_2),   z = h J
//   P_3 = p + h (phi_1 F + 2 phi_2 D_2)                         D_3 = D(h, P_3)
//   p+  = p + h (phi_1 F + phi_2 (4 D_2 - D_3) + 4 phi_3 (D_3 - 2 D_2))
//   int = h p + h^2 (phi_2 F + phi_3 (4 D_2 - D_3) + 4 phi_4 (D_3 - 2 D_2))
// with phi_k(z) = int_0^1 exp((1 - s) z) s^(k-1) / (k-1)! ds. `int` is the integral of the same interpolant:
// the mean that an averaging converter sees is as accurate as the end. |p+ - P_3|, the part of the parabola's
// curvature, is held below ChamberConfig::tolerance_Pa a step. There is no stability limit on h; steps grow
// back to the whole interval when all is calm. Source: "Modeling and Identification of Pneumatic Actuators"
// (4), (7); B: "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve
// Model" (7); the integrator: Cox and Matthews, J. Comput. Phys. 176 (2002), linearised at each step as in
// Hochbruck and Ostermann, Acta Numerica 19 (2010).
#pragma once

#include <cstdint>
#include <optional>

#include "host-sim/plant/gas.hpp"
#include "host-sim/plant/spool.hpp"
#include "host-sim/plant/valve.hpp"
#include "host-sim/plant/volume_motion.hpp"

namespace plenum::host::plant {

struct ChamberConfig {
  Gas gas;                       ///< R T and kappa of the chamber
  double supply_Pa = 700000.0;   ///< P_c, absolute
  double ambient_Pa = 101325.0;  ///< P_r, absolute
  double initial_pressure_Pa = 101325.0;
  double initial_command_V = 5.0;    ///< where the spool rests at the start
  std::optional<SpoolConfig> spool;  ///< none: the command acts at once
  double tolerance_Pa = 2.0;         ///< error estimate allowed in one step
};

/// The pressure over one interval of a held command.
struct Interval {
  double end_Pa = 0.0;
  double mean_Pa = 0.0;
};

/// One valve, its spool and its chamber. A value: a copy is an independent plant in the same state. The same
/// calls give the same bits. Invariants: pressure and volume stay positive.
class ChamberPlant {
 public:
  /// Throws std::invalid_argument naming the field when a figure of `config` is out of range.
  ChamberPlant(const Valve& valve, const ChamberConfig& config, const VolumeMotion& volume);

  /// Moves on by `duration_s` > 0 with `command_V` held. Throws std::invalid_argument when either is not
  /// finite.
  Interval advance(double command_V, double duration_s);

  double pressure_Pa() const { return pressure_Pa_; }
  double time_s() const { return time_s_; }
  VolumeState volume() const { return volume_.at(time_s_); }
  double volume_m3() const { return volume().volume_m3; }
  double volume_rate_m3_s() const { return volume().rate_m3_s; }
  /// The command after the spool: that of the last advance() where there is none.
  double effective_command_V() const { return spool_ ? spool_->effective_V() : command_V_; }

  double supply_Pa() const { return supply_Pa_; }
  double ambient_Pa() const { return ambient_Pa_; }
  const Valve& valve() const { return valve_; }
  const Gas& gas() const { return gas_; }
  /// Steps tried since construction, refused ones included: the cost of the integration.
  std::uint64_t steps_tried() const { return steps_tried_; }

  void set_supply_Pa(double supply_Pa);
  void set_ambient_Pa(double ambient_Pa);
  void set_pressure_Pa(double pressure_Pa);
  void set_volume(const VolumeMotion& volume) { volume_ = volume; }

 private:
  template <class AnyValve>
  Interval integrate(const AnyValve& valve, double command_V, double duration_s);

  Valve valve_;
  Gas gas_;
  VolumeMotion volume_;
  std::optional<Spool> spool_;
  double supply_Pa_;
  double ambient_Pa_;
  double pressure_Pa_;
  double tolerance_Pa_;
  double command_V_;
  double time_s_ = 0.0;
  double next_step_s_ = 1.0;  // what the error control would try next; clipped to the interval
  std::uint64_t steps_tried_ = 0;
};

}  // namespace plenum::host::plant
