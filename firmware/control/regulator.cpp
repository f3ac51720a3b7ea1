#include "firmware/control/regulator.hpp"

namespace plenum::control {

using numeric::clamp;

void Regulator::reset(Scalar pressure_kPa, Scalar command_V) noexcept {
  pressure_kPa_ = pressure_kPa;
  disturbance_kPa_ = Scalar(0);
  acting_V_ = command_V;
  before_V_ = command_V;
}

void Regulator::sent(Scalar command_V) noexcept {
  before_V_ = acting_V_;
  acting_V_ = command_V;
}

Scalar Regulator::observe(const PressureModel& model, Scalar measured_kPa,
                          const ChamberMotion& past) noexcept {
  // Over the tick just past the older command acted until the valve's delay had passed, then the newer one.
  const Scalar delay = config_.valve_delay_ticks;
  const Prediction first = model.step(pressure_kPa_, before_V_, past, delay);
  const Prediction second = model.step(first.end_kPa, acting_V_, past, Scalar(1) - delay);
  const Scalar mean_kPa =
      delay * first.mean_kPa + (Scalar(1) - delay) * second.mean_kPa + Scalar(0.5) * disturbance_kPa_;
  const Scalar residual_kPa = measured_kPa - mean_kPa;

  pressure_kPa_ = second.end_kPa + disturbance_kPa_ + config_.pressure_gain * residual_kPa;
  const Scalar limit = config_.disturbance_limit_kPa;
  disturbance_kPa_ = clamp(disturbance_kPa_ + config_.disturbance_gain * residual_kPa, -limit, limit);
  return residual_kPa;
}

Regulator::Command Regulator::regulate(const PressureModel& model,
                                       const ReferenceShaper::Reference& reference,
                                       const ChamberMotion& next) const noexcept {
  const Scalar delay = config_.valve_delay_ticks;
  const Scalar start_kPa =
      model.step(pressure_kPa_, acting_V_, next, delay).end_kPa + delay * disturbance_kPa_;
  const Scalar start_reference_kPa = reference.now_kPa + delay * (reference.next_kPa - reference.now_kPa);
  const Scalar end_reference_kPa = reference.next_kPa + delay * (reference.after_kPa - reference.next_kPa);

  const Scalar error_kPa = start_kPa - start_reference_kPa;
  const Scalar left_kPa =
      clamp(config_.error_left * error_kPa, -config_.error_left_limit_kPa, config_.error_left_limit_kPa);
  const Inverse inverse =
      model.inverse(start_kPa, end_reference_kPa + left_kPa - disturbance_kPa_, next, acting_V_);
  const Inverse model_alone = model.inverse(start_reference_kPa, end_reference_kPa, next, acting_V_);
  return {
      .command_V = inverse.command_V, .feedforward_V = model_alone.command_V, .saturated = inverse.saturated};
}

Regulator::Command Regulator::feedforward(const PressureModel& model,
                                          const ReferenceShaper::Reference& reference,
                                          const ChamberMotion& next) const noexcept {
  const Scalar delay = config_.valve_delay_ticks;
  const Scalar start_kPa = reference.now_kPa + delay * (reference.next_kPa - reference.now_kPa);
  const Scalar end_kPa = reference.next_kPa + delay * (reference.after_kPa - reference.next_kPa);
  const Inverse inverse = model.inverse(start_kPa, end_kPa, next, acting_V_);
  return {.command_V = inverse.command_V, .feedforward_V = inverse.command_V, .saturated = inverse.saturated};
}

}  // namespace plenum::control
