// The servo cylinder in time, with real stick and slip.
//
// The piston is in one of three motions, each with smooth equations (cylinder_rates.hpp):
//   stuck     xdot = 0; only the gas moves. Left at the instant at which the driving force passes the
//             breakaway force F_c + F_s of (23) in a direction that no end stop bars.
//   forward,  (22) with the sign of (23) held. Left at the instant at which xdot returns to 0 (the piston
//   backward  then sticks, or turns at once if the force suffices), or at which an end stop is met.
// End stops are rigid and take all momentum. A piston without dry friction is not stopped at xdot = 0.
//
// Numerical treatment: Dormand-Prince 5(4) with error control; spools in closed form (plant/spool.hpp) at
// each stage's time; the instants above are bracketed and bisected on the step's continuous extension of
// order 4, and the step is then done again up to there, so that no step crosses a corner of friction. A stuck
// piston's position does not change by a bit. Explicit: beside its supply (or ambient) a chamber is stiff and
// steps fall to about 3 / J, J its rate; 0.2 ms for 50 mL behind 5 mm2. Range and assumptions:
// cylinder_rates.hpp.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems" (1), (20)-(23);
// Dormand and Prince, J. Comput. Appl. Math. 6 (1980); its extension: Hairer, Norsett, Wanner, Solving
// Ordinary Differential Equations I, II.6.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host-sim/plant/servo/cylinder_rates.hpp"

namespace plenum::host::plant::servo {

enum class Motion { kStuck, kForward, kBackward };

/// Two valve ports, their spools, two chambers and the piston. A value: a copy is an independent plant in the
/// same state; the same calls give the same bits. Invariants: pressures positive, |x| <= L/2.
class ServoCylinder {
 public:
  /// At rest. Throws std::invalid_argument naming the field when a figure of `config` is out of range.
  ServoCylinder(const ValvePair& valves, const ServoCylinderConfig& config);

  /// Moves on by `duration_s` > 0 with the commands held. Throws std::invalid_argument when one is not
  /// finite.
  void advance(const Commands& commands_V, double duration_s);

  const CylinderVector& state() const { return y_; }
  double position_m() const { return y_[kPosition]; }
  double velocity_m_s() const { return y_[kVelocity]; }
  /// Of chamber 0 or 1.
  double pressure_Pa(int chamber) const { return y_[chamber == 0 ? kPressure1 : kPressure2]; }
  double temperature_K(int chamber) const;
  Motion motion() const { return motion_; }
  /// Friction as it acts now: of (23) in motion, the balance of the other forces at rest (0 at a stop that
  /// carries them) [N].
  double friction_N() const;
  double time_s() const { return time_s_; }
  const ServoCylinderConfig& config() const { return config_; }
  const ValvePair& valves() const { return valves_; }
  /// Steps tried since construction, refused ones included.
  std::uint64_t steps_tried() const { return steps_tried_; }
  /// How often the piston came to rest and how often it let go.
  std::uint64_t sticks() const { return sticks_; }
  std::uint64_t slips() const { return slips_; }

  /// F_d [N].
  void set_external_force_N(double force_N);

 private:
  struct Trial;
  template <class AnyValve>
  void integrate(const std::array<AnyValve, 2>& valves, const Commands& commands_V, double duration_s);
  template <class AnyValve>
  Trial attempt(const std::array<AnyValve, 2>& valves, const Commands& commands_V, double step_s) const;
  void let_go(double direction);
  bool has_left(Motion motion, const CylinderVector& y) const;
  double release_direction(const CylinderVector& y) const;
  void come_to_rest();
  bool spool_moves(const Commands& commands_V) const;

  ServoCylinderConfig config_;
  ValvePair valves_;
  std::optional<std::array<Spool, 2>> spools_;
  CylinderVector y_;
  CylinderVector scale_;
  Motion motion_ = Motion::kStuck;
  double force_resolution_N_;
  double time_s_ = 0.0;
  double next_step_s_ = 1e-5;
  std::uint64_t steps_tried_ = 0;
  std::uint64_t sticks_ = 0;
  std::uint64_t slips_ = 0;
};

}  // namespace plenum::host::plant::servo
