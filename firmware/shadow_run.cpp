#include "firmware/shadow_run.hpp"

#include <algorithm>
#include <bit>

#include "firmware/numeric/scalar.hpp"

namespace plenum {
namespace {

float square(float x) noexcept {
  return x * x;
}

bool usable(const telemetry::Row& row) noexcept {
  return row.has(telemetry::row_flag::kMeasured) && numeric::is_finite(row.pressure_kPa) &&
         numeric::is_finite(row.volume_mL);
}

std::uint8_t bit(std::size_t chamber) noexcept {
  return static_cast<std::uint8_t>(1U << chamber);
}

}  // namespace

void ShadowRun::Runner::take(const config::ModelParameters& parameters,
                             numeric::Scalar delay_ticks) noexcept {
  known.take_over(parameters, 0, config::kCommandSpan_V);
  const control::ModelPaths paths = control::paths_of(parameters, delay_ticks);
  valve.configure(paths.valve);
  sent.configure(valve.delay_ticks());
  sensor_lag_ticks = paths.sensor_lag_ticks;
  sensor.configure(sensor_lag_ticks, kNoise_kPa);
  line.configure(paths.supply, sent.part_ticks());
  squares = 0.0F;
}

void ShadowRun::Runner::rest(float command_V) noexcept {
  valve.reset(command_V);
  sent.reset(command_V);
  line.reset();
}

void ShadowRun::Runner::start(float shown_kPa, float rise_kPa) noexcept {
  sensor.reset(shown_kPa);
  pressure_kPa = shown_kPa + sensor_lag_ticks * rise_kPa;
}

void ShadowRun::Runner::advance(const Tick& tick) noexcept {
  const control::PressureModel* const model = known.in_force();
  if (model == nullptr) return;
  const control::Prediction predicted = sent.past_tick(*model, pressure_kPa, tick.motion, line);
  squares += square(static_cast<float>(sensor.pass(pressure_kPa, predicted)) - tick.mean_kPa);
  pressure_kPa = predicted.end_kPa;
}

float ShadowRun::Runner::rms_kPa(std::uint32_t ticks) const noexcept {
  return ticks == 0 ? 0.0F : numeric::sqrt(squares / static_cast<float>(ticks));
}

bool ShadowRun::begin(std::uint8_t chamber) noexcept {
  // A new image for the chamber at hand: its comparison begins anew.
  if (chamber_ == chamber) chamber_ = kNobody;
  const bool enough = recorder_.rows() > kLeastMoved * kStretchTicks;
  const unsigned others = waiting_ & ~unsigned{bit(chamber)};
  waiting_ = static_cast<std::uint8_t>(others | (enough ? bit(chamber) : 0U));
  return enough;
}

void ShadowRun::start(std::size_t chamber, const config::ParameterSlots& slots) noexcept {
  chamber_ = chamber;
  waiting_ = static_cast<std::uint8_t>(waiting_ & ~unsigned{bit(chamber)});
  staged_.take(slots.staged(chamber), delay_ticks_);
  active_.take(slots.active(chamber), delay_ticks_);
  next_ = recorder_.begin();
  end_ = recorder_.end();
  followed_ = 0;
  stretch_ticks_ = 0;
  moved_ = 0;
  ticks_ = 0;
}

void ShadowRun::step(config::ParameterSlots& slots) noexcept {
  if (chamber_ != kNobody && !slots.checking(chamber_)) chamber_ = kNobody;
  // The rows of a new log are taken at once: one tick later a rolling recorder would have let go of the first.
  if (chamber_ == kNobody) {
    if (waiting_ == 0) return;
    start(static_cast<std::size_t>(std::countr_zero(waiting_)), slots);
  }
  for (std::uint32_t i = 0; i < kRowsPerTick; ++i) {
    if (take_row()) continue;
    slots.judge(chamber_, result());
    chamber_ = kNobody;
    return;
  }
}

/// The tick from row `number` to the next one.
ShadowRun::Tick ShadowRun::tick_from(std::uint32_t number) const noexcept {
  const telemetry::Row& row = recorder_.row(number, chamber_);
  const telemetry::Row& next = recorder_.row(number + 1, chamber_);
  const bool has_before = number != recorder_.begin() && row.has(telemetry::row_flag::kFollows);
  const telemetry::Row& before = has_before ? recorder_.row(number - 1, chamber_) : row;
  return {.before_V = before.command_V(),
          .command_V = row.command_V(),
          .motion = {.volume_mL = 0.5F * (row.volume_mL + next.volume_mL),
                     .volume_rate_mL_s = (next.volume_mL - row.volume_mL) / config::kTick_s},
          .mean_kPa = next.pressure_kPa};
}

/// One tick of the log. Returns false at its end, also where the recorder has let go of it meanwhile (a new
/// recording was ordered).
bool ShadowRun::take_row() noexcept {
  const bool held = next_ - recorder_.begin() < recorder_.rows();
  if (!held || end_ - next_ < 2) return false;
  const telemetry::Row& row = recorder_.row(next_, chamber_);
  const telemetry::Row& next = recorder_.row(next_ + 1, chamber_);
  if (usable(row) && usable(next) && next.has(telemetry::row_flag::kFollows)) {
    follow(tick_from(next_), row.pressure_kPa);
  } else {
    followed_ = 0;
    stretch_ticks_ = 0;
  }
  ++next_;
  return true;
}

void ShadowRun::follow(const Tick& tick, float mean_before_kPa) noexcept {
  for (Runner* runner : {&staged_, &active_}) {
    if (followed_ == 0) runner->rest(tick.before_V);
    runner->send(tick.command_V);
  }
  if (followed_++ < std::max(staged_.sent.whole_ticks(), active_.sent.whole_ticks())) return;
  compare(tick, mean_before_kPa);
}

void ShadowRun::compare(const Tick& tick, float mean_before_kPa) noexcept {
  if (stretch_ticks_ == 0) {
    start_kPa_ = 0.5F * (mean_before_kPa + tick.mean_kPa);
    const float rise_kPa = tick.mean_kPa - mean_before_kPa;
    staged_.start(start_kPa_, rise_kPa);
    active_.start(start_kPa_, rise_kPa);
    moved_squares_ = 0.0F;
  }
  staged_.advance(tick);
  active_.advance(tick);
  moved_squares_ += square(tick.mean_kPa - start_kPa_);
  ++ticks_;
  if (++stretch_ticks_ < kStretchTicks) return;
  if (moved_squares_ >= static_cast<float>(kStretchTicks) * square(kMoved_kPa)) ++moved_;
  stretch_ticks_ = 0;
}

config::TrialResult ShadowRun::result() const noexcept {
  if (moved_ < kLeastMoved) return {.outcome = config::Trial::not_compared};
  const float staged_kPa = staged_.rms_kPa(ticks_);
  const float active_kPa = active_.rms_kPa(ticks_);
  const bool worse = staged_kPa > kWorse * active_kPa && staged_kPa > active_kPa + kNoise_kPa;
  return {.outcome = worse ? config::Trial::worse : config::Trial::passed,
          .staged_rms_kPa = staged_kPa,
          .active_rms_kPa = active_kPa};
}

}  // namespace plenum
