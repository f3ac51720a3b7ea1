#include "firmware/control/excitation.hpp"

namespace plenum::control {
namespace {

using numeric::clamp;
using numeric::max;
using numeric::min;

constexpr Scalar kNearNull = Scalar(0.1);              // of the way from the null to an end of the range
constexpr Scalar kForced = Scalar(0.25);               // of that way, while a limit is being left
constexpr Scalar kMostApproach = Scalar(4);            // ranges of the pressure
constexpr Scalar kForgetting = Scalar(1.0F / 512.0F);  // a tick, of what exceeds a range: five seconds
constexpr Scalar kAheadTicks =
    Scalar(1.5);  // from the middle of the tick just past to the end of the coming one

// Neighbouring seeds shall not give neighbouring sequences (the finaliser of MurmurHash3, a bijection).
std::uint32_t scramble(std::uint32_t x) noexcept {
  x ^= x >> 16;
  x *= 0x85EBCA6BU;
  x ^= x >> 13;
  x *= 0xC2B2AE35U;
  x ^= x >> 16;
  return x;
}

}  // namespace

void Excitation::configure(const Config& config) noexcept {
  *this = Excitation{};
  config_ = config;
  level_V_ = config.null_V;
  command_V_ = config.null_V;
  command_before_V_ = config.null_V;
  approach_kPa_ = config.approach_kPa;
  const std::uint32_t scrambled = scramble(config.seed + 0x9E3779B9U);
  random_ = scrambled != 0 ? scrambled : 1U;
}

// xorshift32 (Marsaglia, 2003): period 2^32 - 1.
std::uint32_t Excitation::random() noexcept {
  random_ ^= random_ << 13;
  random_ ^= random_ >> 17;
  random_ ^= random_ << 5;
  return random_;
}

Scalar Excitation::uniform(Scalar low, Scalar high) noexcept {
  const Scalar unit = static_cast<Scalar>(random() >> 16) / Scalar(65535);
  return low + unit * (high - low);
}

std::uint32_t Excitation::ticks_between(std::uint32_t low, std::uint32_t high) noexcept {
  return low + (random() >> 8) % (high - low + 1);
}

void Excitation::begin_segment() noexcept {
  const Scalar low_V = config_.command_low_V, high_V = config_.command_high_V, null_V = config_.null_V;
  slope_V_ = 0;
  switch (random() >> 29) {
    case 0: {
      stroke_up_ = !stroke_up_;
      level_V_ = stroke_up_ ? high_V : low_V;
      ticks_left_ = ticks_between(2, 12);
      break;
    }
    case 1: {
      const Scalar target_V = uniform(low_V, high_V);
      ticks_left_ = ticks_between(20, 150);
      slope_V_ = (target_V - level_V_) / static_cast<Scalar>(ticks_left_);
      break;
    }
    case 2:
    case 3: {
      level_V_ = uniform(null_V - kNearNull * (null_V - low_V), null_V + kNearNull * (high_V - null_V));
      ticks_left_ = ticks_between(5, 40);
      break;
    }
    default: {
      level_V_ = uniform(low_V, high_V);
      ticks_left_ = ticks_between(2, 40);
      break;
    }
  }
}

Scalar Excitation::step(Scalar pressure_kPa) noexcept {
  if (ticks_left_ == 0) begin_segment();
  --ticks_left_;
  level_V_ += slope_V_;
  const Scalar wanted_V = numeric::is_finite(pressure_kPa) ? guard(level_V_, pressure_kPa) : config_.null_V;
  command_before_V_ = command_V_;
  command_V_ = clamp(wanted_V, config_.command_low_V, config_.command_high_V);
  return command_V_;
}

Excitation::Room Excitation::room_at_tick_end(Scalar pressure_kPa) noexcept {
  const Scalar change_kPa = has_pressure_ ? pressure_kPa - pressure_before_kPa_ : Scalar(0);
  has_pressure_ = true;
  pressure_before_kPa_ = pressure_kPa;
  // Beyond the range it is forgotten in time: a chamber that crosses it in a tick says so again, one wild sample does not.
  const Scalar range_kPa = config_.pressure_high_kPa - config_.pressure_low_kPa;
  approach_kPa_ -= kForgetting * max(approach_kPa_ - range_kPa, Scalar(0));
  const Scalar seen_kPa = Scalar(2) * numeric::abs(change_kPa);
  // What a small chamber does at full opening its supply cuts short: there a part of the opening tells more.
  const Scalar opened =
      max(max(numeric::abs(opening(command_V_)), numeric::abs(opening(command_before_V_))), kForced);
  const Scalar full_kPa = seen_kPa / opened;
  approach_kPa_ =
      min(max(approach_kPa_, full_kPa > range_kPa ? full_kPa : seen_kPa), kMostApproach * range_kPa);

  // Two ways in which the pressure may have moved on since the mean: by going on as it did (a wall), and,
  // right after a reversal, which two means do not show, by half a tick of the command now held.
  const Scalar held_kPa = approach_kPa_ / Scalar(4);
  const Scalar rise_kPa = max(kAheadTicks * change_kPa, held_kPa * opening(command_V_));
  const Scalar fall_kPa = max(-kAheadTicks * change_kPa, -held_kPa * opening(command_V_));
  return {.above_kPa = config_.pressure_high_kPa - pressure_kPa - max(rise_kPa, Scalar(0)),
          .below_kPa = pressure_kPa - config_.pressure_low_kPa - max(fall_kPa, Scalar(0))};
}

Scalar Excitation::opening(Scalar command_V) const noexcept {
  const Scalar from_null_V = command_V - config_.null_V;
  return from_null_V < Scalar(0) ? from_null_V / (config_.null_V - config_.command_low_V)
                                 : from_null_V / (config_.command_high_V - config_.null_V);
}

Scalar Excitation::command_V(Scalar opening) const noexcept {
  return config_.null_V + opening * (opening < Scalar(0) ? config_.null_V - config_.command_low_V
                                                         : config_.command_high_V - config_.null_V);
}

Scalar Excitation::guard(Scalar wanted_V, Scalar pressure_kPa) noexcept {
  const Room room = room_at_tick_end(pressure_kPa);
  const Scalar back_kPa =
      min(config_.hysteresis_kPa, (config_.pressure_high_kPa - config_.pressure_low_kPa) / Scalar(4));
  if (force_ == Force::exhaust && pressure_kPa <= config_.pressure_high_kPa - back_kPa) force_ = Force::none;
  if (force_ == Force::supply && pressure_kPa >= config_.pressure_low_kPa + back_kPa) force_ = Force::none;
  // Back to the middle in a tick, or as far as the valve can: a small chamber would be thrown from limit to limit.
  const Scalar middle_kPa = numeric::shifted_down<1>(config_.pressure_low_kPa + config_.pressure_high_kPa);
  const auto back = [&](Scalar away_kPa) noexcept {
    return clamp(away_kPa / numeric::shifted_down<1>(approach_kPa_), kForced, Scalar(1));
  };
  if (room.above_kPa <= Scalar(0)) {
    force_ = Force::exhaust;
    return command_V(-back(pressure_kPa - middle_kPa));
  }
  if (room.below_kPa <= Scalar(0)) {
    force_ = Force::supply;
    return command_V(back(middle_kPa - pressure_kPa));
  }
  const Scalar lowest_V = command_V(-min(room.below_kPa / approach_kPa_, Scalar(1)));
  const Scalar highest_V = command_V(min(room.above_kPa / approach_kPa_, Scalar(1)));
  if (force_ == Force::exhaust) return clamp(wanted_V, lowest_V, command_V(-kForced));
  if (force_ == Force::supply) return clamp(wanted_V, command_V(kForced), highest_V);
  return clamp(wanted_V, lowest_V, highest_V);
}

std::optional<Excitation::Config> restrict_to(const Excitation::Config& asked,
                                              const config::ChamberSettings& settings) noexcept {
  Excitation::Config config = asked;
  config.null_V = settings.null_V;
  config.command_low_V = max(asked.command_low_V, Scalar(settings.command_low_V));
  config.command_high_V = min(asked.command_high_V, Scalar(settings.command_high_V));
  config.pressure_low_kPa = max(asked.pressure_low_kPa, Scalar(settings.pressure_low_kPa));
  config.pressure_high_kPa = min(asked.pressure_high_kPa, Scalar(settings.pressure_high_kPa));
  const bool finite = numeric::is_finite(asked.command_low_V) && numeric::is_finite(asked.command_high_V) &&
                      numeric::is_finite(asked.pressure_low_kPa) &&
                      numeric::is_finite(asked.pressure_high_kPa);
  const bool both_ports = config.command_low_V < config.null_V && config.null_V < config.command_high_V;
  if (!finite || !both_ports || !(config.pressure_low_kPa < config.pressure_high_kPa)) return std::nullopt;
  return config;
}

}  // namespace plenum::control
