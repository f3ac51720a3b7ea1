#include "firmware/control/regulator.hpp"

namespace plenum::control {

using numeric::clamp;
using numeric::max;

namespace {

/// Weight of the newest residual in their mean: the last ten ticks or so count.
constexpr Scalar kResidualForgetting = Scalar(0.2);

/// Below this slope a correction in volts means nothing: the ports are sealed.
constexpr Scalar kLeastGain_kPa_V = Scalar(1);

/// The mean over a tick moves by about half of what its end does.
constexpr Scalar kMeanOfEnd = Scalar(0.5);

/// The share of its pressure that compression adds in a tick, were the chamber sealed and isothermal: -v' h/v.
Scalar compressed(const ChamberMotion& motion) noexcept {
  constexpr Scalar kSmallestVolume_mL = Scalar(1);
  return numeric::near_ratio(-motion.volume_rate_mL_s * kTick_s, max(motion.volume_mL, kSmallestVolume_mL));
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
  const auto square = [](Scalar x) noexcept { return x * x; };
  const Scalar steady = square(config.disturbance_deviation_kPa);
  weights_ = {.noise_and_steady = square(config.residual_noise_kPa) + steady * square(kMeanOfEnd),
              .steady_moves = steady * kMeanOfEnd,
              .compression = square(config.compression_deviation),
              .trim = square(config.trim_deviation_V)};
  trim_.configure(
      {.low_V = config.command_low_V, .high_V = config.command_high_V, .limit_V = config.trim_limit_V});
  take_over({.dead_ticks = config.valve_delay_ticks}, Scalar(0));
}

void Regulator::take_over(const ValvePath::Config& valve, Scalar sensor_lag_ticks,
                          const SupplyLine::Config& supply) noexcept {
  valve_.configure(valve);
  sensor_.configure(sensor_lag_ticks, config_.residual_noise_kPa);
  sent_.configure(valve_.delay_ticks());
  line_.configure(supply, sent_.part_ticks());
}

void Regulator::reset(Scalar pressure_kPa, Scalar command_V) noexcept {
  forget(pressure_kPa);
  valve_.reset(command_V);
  sent_.reset(command_V);
}

void Regulator::go_on(Scalar pressure_kPa) noexcept {
  forget(pressure_kPa);
  sent_.pass_again(valve_);
}

/// All but what has been sent.
void Regulator::forget(Scalar pressure_kPa) noexcept {
  trim_.reset();
  sensor_.reset(pressure_kPa);
  line_.reset();
  pressure_kPa_ = pressure_kPa;
  steady_kPa_ = Scalar(0);
  residual_level_kPa_ = Scalar(0);
  compression_ = Scalar(0);
  planned_ = false;
}

void Regulator::sent(Scalar command_V) noexcept {
  const Scalar place_V = valve_.sent(command_V);
  const bool as_planned = planned_ && command_V == planned_V_;
  sent_.push({.command_V = command_V,
              .model_V = as_planned ? plan_.command_V : place_V - trim_.at(place_V),
              .planned = as_planned,
              .by_command_kPa_V = plan_.by_command_kPa_V});
  planned_ = false;
}

Scalar Regulator::disturbance_kPa(Scalar compression_kPa) const noexcept {
  return steady_kPa_ + compression_ * compression_kPa;
}

Prediction Regulator::past_tick(const PressureModel& model, const ChamberMotion& past,
                                Scalar compression_kPa) noexcept {
  const Prediction undisturbed = sent_.past_tick(model, pressure_kPa_, past, line_);
  const Scalar disturbed_kPa = disturbance_kPa(compression_kPa);
  return {.end_kPa = undisturbed.end_kPa + disturbed_kPa,
          .mean_kPa = undisturbed.mean_kPa + kMeanOfEnd * disturbed_kPa};
}

Regulator::Missed Regulator::observe(const PressureModel& model, Scalar measured_kPa,
                                     const ChamberMotion& past) noexcept {
  const Scalar compression_kPa = pressure_kPa_ * compressed(past);
  const Prediction predicted = past_tick(model, past, compression_kPa);
  const SensorLag::Reading reading = sensor_.observe(pressure_kPa_, predicted, measured_kPa);
  const Scalar learned_kPa = learn(reading.above_kPa, compression_kPa);
  residual_level_kPa_ += kResidualForgetting * (numeric::abs(reading.above_kPa) - residual_level_kPa_);
  // what a sensor says that lags is weighed already
  const Scalar gain = sensor_.lags() ? Scalar(1) : config_.pressure_gain;
  pressure_kPa_ = believable_kPa(predicted.end_kPa + gain * reading.above_kPa);
  return {.residual_kPa = reading.missed_kPa, .alone_kPa = reading.missed_kPa + learned_kPa};
}

void Regulator::coast(const PressureModel& model, const ChamberMotion& past) noexcept {
  const Prediction predicted = past_tick(model, past, pressure_kPa_ * compressed(past));
  sensor_.pass(pressure_kPa_, predicted);
  pressure_kPa_ = believable_kPa(predicted.end_kPa);
}

Scalar Regulator::learn(Scalar residual_kPa, Scalar compression_kPa) noexcept {
  const Scalar by_compression = kMeanOfEnd * compression_kPa;
  const SentCommands::Sent& acted = sent_.acted();
  const Scalar by_trim = acted.planned ? -kMeanOfEnd * acted.by_command_kPa_V : Scalar(0);
  const Scalar compression_moves = weights_.compression * by_compression;  // m_i^2 phi_i
  const Scalar trim_moves = weights_.trim * by_trim;
  const CommandTrim::Place place = trim_.place(acted.model_V);
  const Scalar spread = weights_.noise_and_steady + compression_moves * by_compression +
                        trim_moves * by_trim * CommandTrim::reach(place);
  const Scalar share = numeric::near_ratio(residual_kPa, spread);
  const Scalar learned_kPa = kMeanOfEnd * disturbance_kPa(compression_kPa) + by_trim * trim_.at(place);

  const Scalar steady_limit = config_.disturbance_limit_kPa;
  steady_kPa_ = clamp(steady_kPa_ + weights_.steady_moves * share, -steady_limit, steady_limit);
  const Scalar compression_limit = config_.compression_limit;
  compression_ = clamp(compression_ + compression_moves * share, -compression_limit, compression_limit);
  trim_.move(place, trim_moves * share);
  return learned_kPa;
}

Regulator::Span Regulator::acting_span(const ReferenceShaper::Reference& reference) const noexcept {
  return {.from_kPa = reference.at(sent_.whole_ticks(), sent_.part_ticks()),
          .to_kPa = reference.at(sent_.whole_ticks() + 1, sent_.part_ticks())};
}

Regulator::Acting Regulator::stands(const PressureModel& model, Scalar pressure_kPa,
                                    const ChamberMotion& motion) const noexcept {
  Acting acting{.pressure_kPa = pressure_kPa,
                .motion = motion,
                .moves = {},
                .line = {},
                .compressed = compressed(motion)};
  if (line_.droops()) acting.line = line_;  // of another one nothing is asked
  acting.supplied(model, line_.supply());
  return acting;
}

void Regulator::Acting::supplied(const PressureModel& model, Scalar supply) noexcept {
  motion.supply = supply;
  moves = model.moving(motion);
}

Regulator::Acting Regulator::when_it_acts(const PressureModel& model, const ChamberMotion& next) noexcept {
  Acting acting = stands(model, pressure_kPa_, next);
  SupplyLine& line = acting.line;
  const auto advance = [&](std::size_t sent_ticks_ago, Scalar ticks, const SupplyLine::While& span) noexcept {
    const Scalar disturbed_kPa = disturbance_kPa(acting.pressure_kPa * acting.compressed);
    const Prediction undisturbed =
        line.step(span, ticks, model, acting.pressure_kPa, sent_.opening(model, sent_ticks_ago),
                  acting.motion, acting.moves);
    acting.pressure_kPa = undisturbed.end_kPa + ticks * disturbed_kPa;
    if (line.droops()) acting.supplied(model, line.supply());
  };
  advance(sent_.whole_ticks() + 1, sent_.part_ticks(), line.part());
  for (std::size_t ago = sent_.whole_ticks(); ago > 0; --ago) {
    advance(ago, Scalar(1), line.tick());
    acting.motion.volume_mL += acting.motion.volume_rate_mL_s * kTick_s;
    acting.moves = model.moving(acting.motion);
    acting.compressed = compressed(acting.motion);
  }
  return acting;
}

/// What a target asks for is a flow, whatever the supply. So what a first answer draws tells the supply of the second; but no
/// less than the widest opening leaves.
Inverse Regulator::inverse_of(const PressureModel& model, Acting& acting, Scalar target_kPa) const noexcept {
  const Inverse first = model.inverse(acting.pressure_kPa, target_kPa, acting.moves, sent_.ago(1).model_V);
  const SupplyLine& line = acting.line;
  if (!line.droops()) return first;
  const Scalar mean_kPa = Scalar(0.5) * (acting.pressure_kPa + first.reached_kPa);
  const Draw asked = model.draw(mean_kPa, model.opening(first.command_V), acting.moves);
  const Scalar least = line.mean(line.tick(), model, acting.pressure_kPa,
                                 model.opening(config_.command_high_V), acting.motion);
  acting.supplied(model, max(least, line.mean(line.tick(), asked.flow_kPa_L_s)));
  return model.inverse(acting.pressure_kPa, target_kPa, acting.moves, first.command_V);
}

Regulator::Command Regulator::regulate(const PressureModel& model,
                                       const ReferenceShaper::Reference& reference,
                                       const ChamberMotion& next) noexcept {
  const Span wanted = acting_span(reference);
  Acting start = when_it_acts(model, next);
  const Scalar left = numeric::min(config_.error_left + config_.error_left_per_kPa * residual_level_kPa_,
                                   config_.error_left_most);
  const Scalar left_kPa = clamp(left * (start.pressure_kPa - wanted.from_kPa), -config_.error_left_limit_kPa,
                                config_.error_left_limit_kPa);
  const Scalar target_kPa = wanted.to_kPa + left_kPa - disturbance_kPa(pressure_kPa_ * start.compressed);
  plan_ = inverse_of(model, start, target_kPa);
  const Inverse& inverse = plan_;

  // Where the model is at its limit so is the valve: a learned correction does not take full opening away.
  const Scalar trim_V = inverse.saturated ? Scalar(0) : trim_.at(inverse.command_V);
  const Scalar place_V = clamp(inverse.command_V + trim_V, config_.command_low_V, config_.command_high_V);
  const Scalar command_V = valve_.command_for(place_V);
  planned_V_ = clamp(command_V, config_.command_low_V, config_.command_high_V);
  planned_ = planned_V_ == command_V;
  // What of the rise the measurement asked for, beyond that of the reference, in volts at the slope here.
  const Scalar correction_kPa = (target_kPa - start.pressure_kPa) - (wanted.to_kPa - wanted.from_kPa);
  const Scalar slope = max(inverse.by_command_kPa_V, kLeastGain_kPa_V);
  const Scalar feedforward_V = clamp(inverse.command_V - numeric::near_ratio(correction_kPa, slope),
                                     config_.command_low_V, config_.command_high_V);
  return {.command_V = planned_V_, .feedforward_V = feedforward_V, .saturated = inverse.saturated};
}

Regulator::Command Regulator::feedforward(const PressureModel& model,
                                          const ReferenceShaper::Reference& reference,
                                          const ChamberMotion& next) const noexcept {
  const Span wanted = acting_span(reference);
  Acting on_it = stands(model, wanted.from_kPa, next);
  const Inverse inverse = inverse_of(model, on_it, wanted.to_kPa);
  const Scalar command_V =
      clamp(valve_.command_for(inverse.command_V), config_.command_low_V, config_.command_high_V);
  return {.command_V = command_V, .feedforward_V = inverse.command_V, .saturated = inverse.saturated};
}

}  // namespace plenum::control
