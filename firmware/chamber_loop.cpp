#include "firmware/chamber_loop.hpp"

#include "firmware/config/limits.hpp"
#include "firmware/config/units.hpp"

namespace plenum {
namespace {

using config::CubicMetres;
using config::kPascal_per_kPa;
using config::Pascals;
using config::Volts;

/// From an estimate of the volume to its measurement, in ranges of the sensor: no motion takes the observer that far.
constexpr float kFarthest = 10.0F;
/// Weight of the newest tick in the mean of what the model misses: the last five seconds or so of regulation count.
constexpr numeric::Scalar kDriftForgetting = numeric::Scalar(1.0F / 512.0F);
/// So long a volume whose sensor is silent is taken to move on as it did.
constexpr std::uint8_t kBridged_ticks = 4;
constexpr numeric::Scalar kHalf = numeric::Scalar(0.5F);
constexpr numeric::Scalar kHalfTick_s = numeric::Scalar(0.5F * config::kTick_s);

/// No chamber holds a vacuum: 6394h is nobody's yet, and what is held is the pressure at which holding began.
bool stays_where_it_is(const canopen::ChamberImage& image) noexcept {
  return image.hold_setpoint_Pa.value() == numeric::Scalar(0);
}

}  // namespace

void ChamberLoop::configure(const config::ChamberSettings& settings,
                            const control::Regulator::Config& regulator) noexcept {
  settings_ = settings;
  volume_.configure({.tracking_index = config::tracking_index(settings)});
  const config::RampRates ramp = config::ramp_rates(settings);
  shaper_.configure({.low_kPa = settings.pressure_low_kPa,
                     .high_kPa = settings.pressure_high_kPa,
                     .rise_kPa_s = ramp.rise_kPa_s,
                     .fall_kPa_s = ramp.fall_kPa_s});
  control::Regulator::Config limited = regulator;
  limited.command_low_V = settings.command_low_V;
  limited.command_high_V = settings.command_high_V;
  regulator_.configure(limited);
  valve_delay_ticks_ = regulator.valve_delay_ticks;
  allowed_ = {.low_V = settings.command_low_V, .high_V = settings.command_high_V};
  farthest_mL_ = kFarthest * numeric::abs(settings.volume_gain_mL_per_V *
                                          (settings.position_valid_high_V - settings.position_valid_low_V));
  settings_seal_ = config::sum_of_object(settings_);
  constants_seal_ = sum_of_constants();
  paths_seal_ = sum_of_paths();
  state_seal_ = sum_of_state();
  rests_by_settings_ = false;
  if (has_commanded_) return;
  rest_by_settings();
  command_V_ = settings.null_V;
}

void ChamberLoop::rest_by_settings() noexcept {
  resting_ = settings_;
  resting_seal_ = config::sum_of_object(resting_);
  rests_by_settings_ = true;
}

std::uint64_t ChamberLoop::sum_of_constants() const noexcept {
  return volume_.sum_of_constants() + shaper_.sum_of_constants() + regulator_.sum_of_constants() +
         config::sum_of_object(valve_delay_ticks_) + config::sum_of_object(farthest_mL_) +
         config::sum_of_object(allowed_);
}

std::uint64_t ChamberLoop::sum_of_paths() const noexcept {
  return regulator_.sum_of_paths() + config::sum_of_object(drift_limit_kPa_);
}

std::uint64_t ChamberLoop::sum_of_state() const noexcept {
  std::uint64_t sum = volume_.sum_of_estimates() + regulator_.sum_of_estimates();
  if (was_regulating_) sum += shaper_.sum_of_latched();
  if (was_holding_) sum += config::sum_of_object(held_kPa_);
  if (was_exciting_) sum += config::sum_of_object(excitation_) + std::uint64_t{may_excite_};
  return sum + std::uint64_t{pressure_seen_} + (std::uint64_t{volume_seen_} << 8U) +
         (std::uint64_t{volume_unseen_ticks_} << 16U);
}

bool ChamberLoop::state_intact() noexcept {
  if (state_seal_ == sum_of_state()) return true;
  volume_.reset(motion_.volume_mL);
  volume_seen_ = false;
  pressure_seen_ = false;  // and with the next one the regulator begins anew
  was_regulating_ = false;
  was_holding_ = false;
  was_exciting_ = false;
  return false;
}

bool ChamberLoop::intact() noexcept {
  const bool model_intact = model_seal_.look(known_.memory());
  const bool settings_intact = settings_seal_ == config::sum_of_object(settings_);
  const bool constants_intact = constants_seal_ == sum_of_constants() && paths_seal_ == sum_of_paths();
  const bool resting_intact = resting_seal_ == config::sum_of_object(resting_);
  // One copy mends the other: what the outputs rest at counts most while a fault stands.
  if (settings_intact && !resting_intact) rest_by_settings();
  if (!settings_intact && resting_intact && rests_by_settings_) {
    settings_ = resting_;
    settings_seal_ = config::sum_of_object(settings_);
  }
  return model_intact && settings_intact && resting_intact && constants_intact;
}

void ChamberLoop::take_over(const config::ModelParameters& parameters) noexcept {
  // The observer's estimate stands where the last tick began, as the next observation expects; a measurement
  // is a mean, and half a tick older.
  const numeric::Scalar pressure_now_kPa = has_model() ? regulator_.pressure_kPa() : pressure_kPa_;
  known_.take_over(parameters, settings_.command_low_V, settings_.command_high_V);
  model_seal_.close(known_.memory());
  const control::ModelPaths paths = control::paths_of(parameters, valve_delay_ticks_);
  regulator_.take_over(paths.valve, paths.sensor_lag_ticks, paths.supply);
  drift_kPa_ = 0;
  drift_limit_kPa_ = safety::drift_limit_kPa(settings_, parameters.fit_error_kPa);
  paths_seal_ = sum_of_paths();
  if (pressure_seen_) {
    regulator_.go_on(pressure_now_kPa);  // no bump
  } else {
    regulator_.reset(pressure_now_kPa, command_V_);
  }
  state_seal_ = sum_of_state();
}

/// What is no number never becomes one again by itself, and from far off a filter takes seconds to come back.
void ChamberLoop::observe_volume(numeric::Scalar measured_mL) noexcept {
  if (!volume_seen_) volume_.reset(measured_mL);
  volume_seen_ = true;
  volume_unseen_ticks_ = 0;
  motion_ = volume_.step(measured_mL);
  // written so that what is no number is not near
  const bool near = numeric::abs(motion_.volume_mL - measured_mL) <= farthest_mL_ &&
                    numeric::abs(motion_.volume_rate_mL_s * numeric::Scalar(config::kTick_s)) <= farthest_mL_;
  if (near) return;
  volume_.reset(measured_mL);
  motion_ = {.volume_mL = measured_mL, .volume_rate_mL_s = numeric::Scalar(0)};
}

/// What the position sensor can say.
numeric::Scalar ChamberLoop::within_stroke(numeric::Scalar volume_mL) const noexcept {
  const numeric::Scalar one_mL = config::volume_mL(settings_, settings_.position_valid_low_V);
  const numeric::Scalar other_mL = config::volume_mL(settings_, settings_.position_valid_high_V);
  return numeric::clamp(volume_mL, numeric::min(one_mL, other_mL), numeric::max(one_mL, other_mL));
}

/// Without a measurement it goes on as it moved, within its stroke, and soon nobody knows how: then it is at rest where it has come
/// to, and a measurement that comes begins anew.
void ChamberLoop::bridge_volume() noexcept {
  if (volume_unseen_ticks_ < kBridged_ticks && volume_seen_) {
    ++volume_unseen_ticks_;
    const control::ChamberMotion next = volume_.coast();
    motion_ = {.volume_mL = within_stroke(next.volume_mL), .volume_rate_mL_s = next.volume_rate_mL_s};
    if (motion_.volume_mL == next.volume_mL) return;
  }
  volume_seen_ = false;
  motion_.volume_rate_mL_s = 0;
  volume_.reset(motion_.volume_mL);
}

/// Every estimate of the regulator, from what is measured.
void ChamberLoop::begin_anew() noexcept {
  regulator_.reset(pressure_kPa_, command_V_);
  residual_kPa_ = 0;
}

void ChamberLoop::observe_pressure(const control::PressureModel& model) noexcept {
  const control::Regulator::Missed missed = regulator_.observe(model, pressure_kPa_, volume_.past());
  residual_kPa_ = missed.residual_kPa;
  // At rest a chamber says little, and whoever excites it may be after another model.
  if (!was_regulating_) return;
  const numeric::Scalar mean_kPa =
      drift_kPa_ + kDriftForgetting * (numeric::abs(missed.alone_kPa) - drift_kPa_);
  drift_kPa_ = numeric::is_finite(mean_kPa) ? mean_kPa : numeric::Scalar(0);
}

safety::FaultSet ChamberLoop::measure(const Measured& readings, bool regulation_asked,
                                      bool model_needed) noexcept {
  const safety::ChamberMonitor::Output seen =
      monitor_.step(settings_, {.ticks = readings.ticks,
                                .pressure_V = readings.pressure.mean_V,
                                .pressure_fresh = readings.pressure.fresh,
                                .pressure_at_end = readings.pressure.at_end,
                                .position_V = readings.position.mean_V,
                                .position_fresh = readings.position.fresh,
                                .residual_kPa = residual_kPa_,
                                .drift_kPa = drift_kPa_,
                                .drift_limit_kPa = drift_limit_kPa_,
                                .regulated = was_regulating_,
                                .reference_kPa = reference_kPa_,
                                .command_V = command_V_,
                                .driven = was_regulating_ || was_exciting_,
                                .regulation_asked = regulation_asked,
                                .model_ready = has_model() || !model_needed});
  seen_ = static_cast<std::uint8_t>(
      (seen.on_target ? canopen::regulation::kOnTarget : 0U) |
      (safety::holds(seen.causes, safety::Fault::control_deviation) ? canopen::regulation::kDeviates : 0U));
  if (seen.position_usable) {
    observe_volume(config::volume_mL(settings_, readings.position.mean_V));
  } else {
    bridge_volume();
  }

  if (readings.supply_kPa > numeric::Scalar(0)) regulator_.supply_measured(readings.supply_kPa);
  const control::PressureModel* const model = known_.in_force();
  residual_kPa_ = 0;
  pressure_fresh_ = seen.pressure_usable;
  if (pressure_fresh_) {
    pressure_kPa_ = seen.pressure_kPa;
    if (!pressure_seen_) regulator_.reset(pressure_kPa_, command_V_);
    pressure_seen_ = true;
    if (model != nullptr) observe_pressure(*model);
  } else if (pressure_seen_ && model != nullptr) {
    regulator_.coast(*model, volume_.past());
  }
  if (!regulator_.knows_numbers()) begin_anew();
  return seen.causes;
}

float ChamberLoop::command(const Order& order, canopen::ChamberImage& image) noexcept {
  if (order.commanded && !rests_by_settings_) rest_by_settings();
  has_commanded_ = true;
  image.deviation_Pa =
      Pascals::of_core(was_regulating_ ? reference_kPa_ - pressure_kPa_ : numeric::Scalar(0));
  numeric::Scalar driven = driven_V(order, image);
  if (!numeric::is_finite(driven)) {
    begin_anew();
    driven = resting_V();
  }
  // Whatever has become of a setting, no converter is asked for more than it has; of no number for 0 V.
  driven = numeric::min(numeric::max(numeric::Scalar(0), driven), numeric::Scalar(config::kCommandSpan_V));
  command_V_ = order.powered ? driven : numeric::Scalar(settings_.null_V);
  regulator_.sent(command_V_);  // what the valve does, to learn nothing false

  image.actual_Pa = Pascals::of_core(pressure_kPa_);
  image.volume_m3 = CubicMetres::of_core(motion_.volume_mL - motion_.volume_rate_mL_s * kHalfTick_s);
  image.command_V = Volts::of_core(driven);
  image.feedback_V = Volts::of_core(driven - image.feedforward_V.in_core());
  image.residual_Pa = Pascals::of_core(residual_kPa_);
  image.drift_Pa = Pascals::of_core(drift_kPa_);
  state_seal_ = sum_of_state();
  return static_cast<float>(driven);
}

numeric::Scalar ChamberLoop::driven_V(const Order& order, canopen::ChamberImage& image) noexcept {
  const bool excitation = order.mode == canopen::ControlMode::excitation;
  const bool driven = settings_.in_use && pressure_seen_ && !order.must_vent;
  const bool exciting = driven && excitation && order.drive == safety::Drive::active;
  const bool regulating = driven && !excitation && has_model() &&
                          (order.drive == safety::Drive::active || order.drive == safety::Drive::hold);
  if (exciting && !was_exciting_) begin_excitation(order, image.excitation);
  const bool holding = regulating && order.drive == safety::Drive::hold;
  const bool begins_to_hold = holding && !was_holding_;
  if (begins_to_hold) held_kPa_ = pressure_kPa_;
  // No ramp leads to where the chamber is: on its way it would follow what it was to leave.
  if ((regulating && !was_regulating_) || (begins_to_hold && stays_where_it_is(image)))
    shaper_.reset(pressure_kPa_);
  was_exciting_ = exciting;
  was_regulating_ = regulating;
  was_holding_ = holding;

  // What bounds the regulator and the excitation themselves are copies of their own, which a flipped bit makes another range.
  const auto allowed = [this](numeric::Scalar command_V) noexcept {
    return numeric::clamp(command_V, allowed_.low_V, allowed_.high_V);
  };
  if (regulating) return allowed(regulated_V(order, image));
  image.feedforward_V = settings_.null_V;
  image.demand_Pa = Pascals::of_core(pressure_kPa_);
  image.regulation = 0;
  // The guard of the excitation lives on fresh pressures: without one the ports are shut.
  // Within limits that leave nothing they stay shut.
  if (exciting)
    return pressure_fresh_ && may_excite_ ? allowed(excitation_.step(pressure_kPa_)) : settings_.null_V;
  const safety::Drive resting = order.drive == safety::Drive::vent ? order.drive : safety::Drive::safe;
  return safety::resting_command_V(resting_, resting, order.must_vent);
}

void ChamberLoop::begin_excitation(const Order& order, const canopen::ExcitationImage& asked) noexcept {
  const auto allowed = control::restrict_to({.seed = order.excitation_seed,
                                             .command_low_V = asked.command_low_V,
                                             .command_high_V = asked.command_high_V,
                                             .null_V = settings_.null_V,
                                             .pressure_low_kPa = asked.pressure_low_Pa / kPascal_per_kPa,
                                             .pressure_high_kPa = asked.pressure_high_Pa / kPascal_per_kPa},
                                            settings_);
  may_excite_ = allowed.has_value();
  if (allowed) excitation_.configure(*allowed);
}

numeric::Scalar ChamberLoop::regulated_V(const Order& order, canopen::ChamberImage& image) noexcept {
  const bool active = order.drive == safety::Drive::active;
  const bool stays = !active && stays_where_it_is(image);
  const numeric::Scalar setpoint_kPa =
      stays ? held_kPa_ : numeric::thousandth(active ? image.setpoint_Pa : image.hold_setpoint_Pa);
  const control::ReferenceShaper::Reference& reference =
      shaper_.step(setpoint_kPa, active ? order.preview_ticks : std::uint8_t{0}, regulator_.ahead());
  const control::PressureModel& model = *known_.in_force();
  const bool open_loop = order.mode == canopen::ControlMode::pressure_open_loop;
  const control::Regulator::Command command = open_loop ? regulator_.feedforward(model, reference, motion_)
                                                        : regulator_.regulate(model, reference, motion_);
  image.feedforward_V = Volts::of_core(command.feedforward_V);
  image.demand_Pa = Pascals::of_core(reference.kPa[1]);
  image.regulation =
      static_cast<std::uint8_t>(seen_ | (shaper_.ramp_runs() ? canopen::regulation::kRampRuns : 0U) |
                                (shaper_.limit_touched() ? canopen::regulation::kLimitTouched : 0U));
  reference_kPa_ = reference.at(0, kHalf);
  return command.command_V;
}

}  // namespace plenum
