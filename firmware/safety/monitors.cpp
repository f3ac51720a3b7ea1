#include "firmware/safety/monitors.hpp"

#include <bit>

#include "firmware/numeric/nearest.hpp"

namespace plenum::safety {
namespace {

constexpr FaultSet if_so(bool condition, Fault fault) noexcept {
  return condition ? only(fault) : FaultSet{0};
}

struct Signal {
  bool finite;
  bool in_range;
};

Signal judge(float sensor_V, float valid_low_V, float valid_high_V) noexcept {
  using numeric::place_of;
  const std::int32_t place = place_of(sensor_V);
  return {numeric::is_finite(sensor_V), place >= place_of(valid_low_V) && place <= place_of(valid_high_V)};
}

bool above(float value, float limit) noexcept {
  return numeric::place_of(value) > numeric::place_of(limit);
}

// 0 ticks switch a check off.
bool lasts(std::uint16_t count, std::uint16_t limit_ticks) noexcept {
  return limit_ticks != 0 && count >= limit_ticks;
}

/// So many ticks on end are as long as that; at least one.
bool lasts_ms(std::uint16_t ticks, std::uint16_t time_ms) noexcept {
  constexpr std::uint32_t kTick_ms = config::kTick_us / 1000;
  return ticks != 0 && ticks * kTick_ms >= time_ms;
}

/// No model is taken to fit better: sensors are noisier on one day than on another.
constexpr float kLeastFit_kPa = 0.2F;

}  // namespace

numeric::Scalar drift_limit_kPa(const config::ChamberSettings& settings, float fit_error_kPa) noexcept {
  if (!(fit_error_kPa > 0.0F)) return 0;
  return numeric::Scalar(settings.drift_alarm_ratio * numeric::max(fit_error_kPa, kLeastFit_kPa));
}

/// A tick without a usable pressure says nothing for or against.
void ChamberMonitor::watch_deviation(const config::ChamberSettings& settings, const Input& in,
                                     const Output& seen) noexcept {
  if (in.regulated && !seen.pressure_usable) return;
  const auto within = [&](float low_kPa, float high_kPa) noexcept {
    const numeric::Scalar deviation_kPa = in.reference_kPa - numeric::Scalar(seen.pressure_kPa);
    return deviation_kPa >= numeric::Scalar(low_kPa) && deviation_kPa <= numeric::Scalar(high_kPa);
  };
  const bool deviates = settings.deviation_watched && in.regulated &&
                        !within(settings.deviation_low_kPa, settings.deviation_high_kPa);
  const bool near =
      settings.target_watched && in.regulated && within(settings.target_low_kPa, settings.target_high_kPa);
  deviating_.go_on(deviates, in.ticks);
  within_target_.go_on(near, in.ticks);
}

ChamberMonitor::Output ChamberMonitor::step(const config::ChamberSettings& settings,
                                            const Input& in) noexcept {
  if (!settings.in_use) {
    *this = ChamberMonitor{};
    return {};
  }
  Signal pressure = judge(in.pressure_V, settings.pressure_valid_low_V, settings.pressure_valid_high_V);
  pressure.in_range = pressure.in_range && !in.pressure_at_end;
  const Signal position = judge(in.position_V, settings.position_valid_low_V, settings.position_valid_high_V);
  Output out;
  out.pressure_usable = in.pressure_fresh && pressure.finite && pressure.in_range;
  out.position_usable = in.position_fresh && position.finite && position.in_range;

  // What did not arrive in this tick is an old value, and was judged when it came.
  out.causes |= if_so(lasts(pressure_stale_.step(!in.pressure_fresh, in.ticks), settings.stale_limit_ticks),
                      Fault::pressure_stale);
  out.causes |= if_so(in.pressure_fresh && !pressure.finite, Fault::pressure_not_finite);
  out.causes |=
      if_so(in.pressure_fresh && pressure.finite && !pressure.in_range, Fault::pressure_out_of_range);
  out.causes |= if_so(lasts(position_stale_.step(!in.position_fresh, in.ticks), settings.stale_limit_ticks),
                      Fault::position_stale);
  out.causes |= if_so(in.position_fresh && !position.finite, Fault::position_not_finite);
  out.causes |=
      if_so(in.position_fresh && position.finite && !position.in_range, Fault::position_out_of_range);

  // Air in motion and a converter's noise let no two ticks agree for long, bit by bit.
  const bool stands_still =
      in.driven && in.pressure_fresh &&
      std::bit_cast<std::uint32_t>(in.pressure_V) == std::bit_cast<std::uint32_t>(pressure_before_V_);
  pressure_before_V_ = in.pressure_V;
  lowest_V_ = stands_still ? numeric::min(lowest_V_, in.command_V) : in.command_V;
  highest_V_ = stands_still ? numeric::max(highest_V_, in.command_V) : in.command_V;
  const auto valve_moved = [&]() noexcept {
    const float range_V = settings.command_high_V - settings.command_low_V;
    return highest_V_ - lowest_V_ > numeric::Scalar(kStuckMoved * range_V);
  };
  out.causes |=
      if_so(lasts(still_.step(stands_still), settings.stuck_ticks) && valve_moved(), Fault::pressure_stuck);

  // Once tripped, the cause lasts until the pressure is back among the admissible references. A tick without
  // a usable pressure says nothing for or against. A reading above the valid range still counts as too much
  // pressure.
  if (in.pressure_fresh && pressure.finite) {
    out.pressure_kPa = config::pressure_kPa(settings, in.pressure_V);
    const std::uint16_t count =
        over_pressure_.go_on(above(out.pressure_kPa, settings.over_pressure_kPa), in.ticks);
    over_pressure_tripped_ = count >= settings.over_pressure_ticks ||
                             (over_pressure_tripped_ && above(out.pressure_kPa, settings.pressure_high_kPa));
  }
  out.causes |= if_so(over_pressure_tripped_, Fault::over_pressure);

  // Written so that a residual that is not a number counts as too large.
  const bool residual_small = numeric::abs(in.residual_kPa) <= numeric::Scalar(settings.residual_alarm_kPa);
  out.causes |= if_so(lasts(residual_.step(!residual_small), settings.residual_ticks), Fault::model_residual);
  const numeric::Scalar limit_kPa = drifted_ ? kDriftGone * in.drift_limit_kPa : in.drift_limit_kPa;
  drifted_ = in.drift_limit_kPa > numeric::Scalar(0) && in.drift_kPa > limit_kPa;
  out.causes |= if_so(drifted_, Fault::model_drift);
  watch_deviation(settings, in, out);
  out.causes |= if_so(lasts_ms(deviating_.ticks(), settings.deviation_delay_ms), Fault::control_deviation);
  out.on_target = lasts_ms(within_target_.ticks(), settings.target_time_ms);
  out.causes |= if_so(in.regulation_asked && !in.model_ready, Fault::no_model);
  return out;
}

bool supply_suffices(const config::BoardSettings& settings, float sensor_V, bool fresh) noexcept {
  return fresh && config::supply_kPa(settings, sensor_V) >= settings.supply_low_kPa;
}

FaultSet BoardMonitor::step(const config::BoardSettings& settings, const Input& in) noexcept {
  const bool setpoint_came = in.setpoint_count != setpoint_count_before_;
  setpoint_count_before_ = in.setpoint_count;
  const std::uint16_t silence = setpoint_silence_.step(in.setpoints_needed && !setpoint_came, in.ticks);
  const bool supply_watched = settings.supply_low_kPa > 0.0F;
  const bool supply_short = supply_watched && !supply_suffices(settings, in.supply_V, in.supply_fresh);

  FaultSet causes = 0;
  causes |= if_so(in.emergency_stop, Fault::emergency_stop);
  causes |= if_so(!in.outputs_ok, Fault::hardware);
  causes |= if_so(in.memory_upset, Fault::memory_upset);
  causes |= if_so(in.configuration_refused, Fault::configuration_refused);
  causes |= if_so(lasts(late_.step(in.tick_late), settings.overrun_limit_ticks), Fault::tick_overrun);
  causes |= if_so(in.bus_off, Fault::bus_off);
  causes |= if_so(in.heartbeat_lost, Fault::heartbeat_lost);
  causes |=
      if_so(in.setpoint_lost || lasts(silence, settings.setpoint_watchdog_ticks), Fault::setpoint_timeout);
  causes |= if_so(lasts(supply_low_.go_on(supply_short, in.ticks), settings.supply_ticks), Fault::supply_low);
  causes |= if_so(in.stored_set_lost, Fault::stored_set_lost);
  causes |= if_so(in.store_failing, Fault::store_failing);
  causes |= if_so(in.frames_lost, Fault::can_overrun);
  causes |= if_so(in.error_passive, Fault::can_passive);
  causes |= if_so(in.pdo_short, Fault::pdo_short);
  causes |= if_so(in.pdo_long, Fault::pdo_long);
  causes |= if_so(in.sync_misfits, Fault::sync_refused);
  return causes;
}

}  // namespace plenum::safety
