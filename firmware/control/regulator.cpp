#include "firmware/control/regulator.hpp"

#include "firmware/config/limits.hpp"

namespace plenum::control {

using numeric::clamp;
using numeric::max;

namespace {

constexpr Scalar kTick_s = Scalar(config::kTick_s);

/// Weight of the newest residual in their mean: the last ten ticks or so count.
constexpr Scalar kResidualForgetting = Scalar(0.2);

/// Below this slope a correction in volts means nothing: the ports are sealed.
constexpr Scalar kLeastSlope_kPa_V = Scalar(1);

/// The pressure that compression adds in a tick, were the chamber sealed and isothermal: -p v' h/v.
Scalar compression_kPa(Scalar pressure_kPa, const ChamberMotion& motion) noexcept {
  constexpr Scalar kSmallestVolume_mL = Scalar(1);
  return -pressure_kPa * motion.volume_rate_mL_s * kTick_s / max(motion.volume_mL, kSmallestVolume_mL);
}

/// No gas has less, no chamber has more. Without bounds a volume signal that jumps about multiplies the
/// estimate by the compression it feigns, tick by tick, until it is not a number and stays so.
Scalar believable_kPa(Scalar pressure_kPa) noexcept {
  constexpr Scalar kMost_kPa = Scalar(10000);
  return clamp(pressure_kPa, Scalar(0), kMost_kPa);
}

}  // namespace

void Regulator::configure(const Config& config) noexcept {
  config_ = config;
  trim_.configure(
      {.low_V = config.command_low_V, .high_V = config.command_high_V, .limit_V = config.trim_limit_V});
}

void Regulator::reset(Scalar pressure_kPa, Scalar command_V) noexcept {
  trim_.reset();
  pressure_kPa_ = pressure_kPa;
  steady_kPa_ = Scalar(0);
  residual_level_kPa_ = Scalar(0);
  compression_ = Scalar(0);
  acting_V_ = command_V;
  before_V_ = command_V;
  planned_ = false;
  learning_ = false;
}

void Regulator::sent(Scalar command_V) noexcept {
  before_V_ = acting_V_;
  learning_ = planned_ && command_V == planned_V_;
  acting_V_ = learning_ ? planned_model_V_ : command_V - trim_.at(command_V);
  planned_ = false;
}

Scalar Regulator::disturbance_kPa(const ChamberMotion& motion) const noexcept {
  return steady_kPa_ + compression_ * compression_kPa(pressure_kPa_, motion);
}

Prediction Regulator::past_tick(const PressureModel& model, const ChamberMotion& past) const noexcept {
  // The older command acted until the valve's delay had passed, then the newer one.
  const Scalar delay = config_.valve_delay_ticks;
  const Scalar rest = Scalar(1) - delay;
  const Scalar disturbed_kPa = disturbance_kPa(past);
  const Prediction first = model.step(pressure_kPa_, before_V_, past, delay);
  const Prediction second = model.step(first.end_kPa, acting_V_, past, rest);
  return {.end_kPa = second.end_kPa + disturbed_kPa,
          .mean_kPa = delay * first.mean_kPa + rest * second.mean_kPa + Scalar(0.5) * disturbed_kPa};
}

Scalar Regulator::observe(const PressureModel& model, Scalar measured_kPa,
                          const ChamberMotion& past) noexcept {
  const Prediction predicted = past_tick(model, past);
  const Scalar residual_kPa = measured_kPa - predicted.mean_kPa;
  learn(model, residual_kPa, past);
  residual_level_kPa_ += kResidualForgetting * (numeric::abs(residual_kPa) - residual_level_kPa_);
  pressure_kPa_ = believable_kPa(predicted.end_kPa + config_.pressure_gain * residual_kPa);
  return residual_kPa;
}

void Regulator::coast(const PressureModel& model, const ChamberMotion& past) noexcept {
  pressure_kPa_ = believable_kPa(past_tick(model, past).end_kPa);
}

void Regulator::learn(const PressureModel& model, Scalar residual_kPa, const ChamberMotion& past) noexcept {
  const auto square = [](Scalar x) noexcept { return x * x; };
  // The mean over a tick moves by about half of what its end does.
  constexpr Scalar kMeanOfEnd = Scalar(0.5);
  const Scalar by_compression = kMeanOfEnd * compression_kPa(pressure_kPa_, past);
  const Scalar by_trim =
      learning_ ? -kMeanOfEnd * model.derivatives(pressure_kPa_, acting_V_, past).by_command_kPa_V
                : Scalar(0);
  const Scalar steady_weight = square(config_.disturbance_deviation_kPa);
  const Scalar compression_weight = square(config_.compression_deviation);
  const Scalar trim_weight = square(config_.trim_deviation_V);
  const Scalar spread = square(config_.residual_noise_kPa) + steady_weight * square(kMeanOfEnd) +
                        compression_weight * square(by_compression) +
                        trim_weight * square(by_trim) * trim_.reach(acting_V_);
  const Scalar share = residual_kPa / spread;

  const Scalar steady_limit = config_.disturbance_limit_kPa;
  steady_kPa_ = clamp(steady_kPa_ + steady_weight * kMeanOfEnd * share, -steady_limit, steady_limit);
  const Scalar compression_limit = config_.compression_limit;
  compression_ = clamp(compression_ + compression_weight * by_compression * share, -compression_limit,
                       compression_limit);
  trim_.move(acting_V_, trim_weight * by_trim * share);
}

Regulator::Span Regulator::acting_span(const ReferenceShaper::Reference& reference) const noexcept {
  const Scalar delay = config_.valve_delay_ticks;
  return {.from_kPa = reference.now_kPa + delay * (reference.next_kPa - reference.now_kPa),
          .to_kPa = reference.next_kPa + delay * (reference.after_kPa - reference.next_kPa)};
}

Regulator::Command Regulator::regulate(const PressureModel& model,
                                       const ReferenceShaper::Reference& reference,
                                       const ChamberMotion& next) noexcept {
  const Scalar delay = config_.valve_delay_ticks;
  const Span wanted = acting_span(reference);
  const Scalar disturbed_kPa = disturbance_kPa(next);
  const Scalar start_kPa = model.step(pressure_kPa_, acting_V_, next, delay).end_kPa + delay * disturbed_kPa;
  const Scalar left = numeric::min(config_.error_left + config_.error_left_per_kPa * residual_level_kPa_,
                                   config_.error_left_most);
  const Scalar left_kPa = clamp(left * (start_kPa - wanted.from_kPa), -config_.error_left_limit_kPa,
                                config_.error_left_limit_kPa);
  const Scalar target_kPa = wanted.to_kPa + left_kPa - disturbed_kPa;
  const Inverse inverse = model.inverse(start_kPa, target_kPa, next, acting_V_);

  planned_ = true;
  planned_model_V_ = inverse.command_V;
  // Where the model is at its limit so is the valve: a learned correction does not take full opening away.
  const Scalar trim_V = inverse.saturated ? Scalar(0) : trim_.at(inverse.command_V);
  planned_V_ = clamp(inverse.command_V + trim_V, config_.command_low_V, config_.command_high_V);
  // What of the rise the measurement asked for, beyond that of the reference, in volts at the slope here.
  const Scalar correction_kPa = (target_kPa - start_kPa) - (wanted.to_kPa - wanted.from_kPa);
  const Scalar slope =
      max(model.derivatives(start_kPa, inverse.command_V, next).by_command_kPa_V, kLeastSlope_kPa_V);
  const Scalar feedforward_V =
      clamp(inverse.command_V - correction_kPa / slope, config_.command_low_V, config_.command_high_V);
  return {.command_V = planned_V_, .feedforward_V = feedforward_V, .saturated = inverse.saturated};
}

Regulator::Command Regulator::feedforward(const PressureModel& model,
                                          const ReferenceShaper::Reference& reference,
                                          const ChamberMotion& next) const noexcept {
  const Span wanted = acting_span(reference);
  const Inverse inverse = model.inverse(wanted.from_kPa, wanted.to_kPa, next, acting_V_);
  return {.command_V = inverse.command_V, .feedforward_V = inverse.command_V, .saturated = inverse.saturated};
}

}  // namespace plenum::control
