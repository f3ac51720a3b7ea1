// Pressure regulator of one chamber: model inversion as feedforward, a disturbance estimate against steady
// error.
//
// Each tick, at its start:
//   1. observe  the pressure measured over the tick just past (a mean: it lags by half a tick) corrects the
//   estimate
//               of the pressure now, p^, and of the disturbance d: what the model misses, in kPa a tick.
//   2. predict  the valve answers a command `valve_delay_ticks` late; the pressure is carried over that delay
//   with the
//               command that still acts (a Smith predictor).
//   3. invert   the command that takes it, in one tick of action, to
//                  target = reference + share of the present error that may stay - d
//               the reference being the one for the end of that action, known in advance where the set-point
//               stream has preview.
//
// The disturbance is estimated with the command that was really sent, after limits: at a limit nothing winds
// up. The observer runs whether or not the regulator drives, so that it takes over without a bump.
//
// The regulator knows its model only by PressureModel.
#pragma once

#include "firmware/control/pressure_model.hpp"
#include "firmware/control/reference_shaper.hpp"

namespace plenum::control {

class Regulator {
 public:
  struct Config {
    /// Time from a command to the valve's answer, in ticks, 0 to 1: a spool of natural frequency f and
    /// damping z answers like a delay of z / (pi f).
    Scalar valve_delay_ticks = Scalar(0);
    /// Gains of the observer on the innovation: on the pressure [1] and on the disturbance [1/tick].
    Scalar pressure_gain = Scalar(0.8);
    Scalar disturbance_gain = Scalar(0.2);
    Scalar disturbance_limit_kPa = Scalar(40);  ///< largest disturbance believed, a tick
    /// The share of a small tracking error that is left after one tick: softens the answer to noise.
    Scalar error_left = Scalar(0.3);
    /// The most that is left of any error [kPa]: a large error is a step, and is answered at once.
    Scalar error_left_limit_kPa = Scalar(1);
  };

  struct Command {
    Scalar command_V = 0;
    Scalar feedforward_V = 0;  ///< what the model alone would send on the reference
    bool saturated = false;
  };

  void configure(const Config& config) noexcept { config_ = config; }

  /// The chamber stands at `pressure_kPa`, the valve at `command_V`; no disturbance is known.
  void reset(Scalar pressure_kPa, Scalar command_V) noexcept;

  /// Step 1. Returns the model residual: measured minus predicted mean of the tick just past [kPa].
  Scalar observe(const PressureModel& model, Scalar measured_kPa, const ChamberMotion& past) noexcept;

  /// Steps 2 and 3, closed loop.
  Command regulate(const PressureModel& model, const ReferenceShaper::Reference& reference,
                   const ChamberMotion& next) const noexcept;

  /// Pure feedforward: the command that takes a chamber on the reference along it. No measured pressure
  /// enters.
  Command feedforward(const PressureModel& model, const ReferenceShaper::Reference& reference,
                      const ChamberMotion& next) const noexcept;

  /// Whatever was sent to the valve this tick, by this regulator or not.
  void sent(Scalar command_V) noexcept;

  Scalar pressure_kPa() const noexcept { return pressure_kPa_; }
  Scalar disturbance_kPa() const noexcept { return disturbance_kPa_; }

 private:
  Config config_;
  Scalar pressure_kPa_ = 0;     ///< estimate at the start of the tick at hand
  Scalar disturbance_kPa_ = 0;  ///< estimate, a tick
  Scalar acting_V_ = 0;         ///< the command sent one tick ago: it acts until the delay has passed
  Scalar before_V_ = 0;         ///< the one before it
};

}  // namespace plenum::control
