#include "firmware/control/valve_path.hpp"

namespace plenum::control {

void ValvePath::configure(const Config& config) noexcept {
  half_play_V_ = Scalar(0.5) * config.play_V;
  const bool lags = config.lag_ticks > Scalar(1) / numeric::kDecayHigh;
  done_ = lags ? numeric::decay(Scalar(1) / config.lag_ticks) : Scalar(1);
  const Scalar behind_ticks = config.lag_ticks + Scalar(1) - Scalar(1) / done_;
  delay_ticks_ = numeric::clamp(config.dead_ticks + behind_ticks, Scalar(0), kMostDelay_ticks);
}

void ValvePath::reset(Scalar command_V) noexcept {
  command_V_ = command_V;
  held_V_ = command_V;
  place_V_ = command_V;
}

Scalar ValvePath::command_for(Scalar place_V) const noexcept {
  const Scalar held_V = done_ < Scalar(1) ? place_V_ + (place_V - place_V_) / done_ : place_V;
  if (half_play_V_ <= Scalar(0)) return held_V;
  // within the play the spool stays where it is
  if (held_V == held_V_) return command_V_;
  return held_V > held_V_ ? held_V + half_play_V_ : held_V - half_play_V_;
}

Scalar ValvePath::sent(Scalar command_V) noexcept {
  command_V_ = command_V;
  held_V_ = numeric::clamp(held_V_, command_V - half_play_V_, command_V + half_play_V_);
  place_V_ = done_ < Scalar(1) ? place_V_ + (held_V_ - place_V_) * done_ : held_V_;
  return place_V_;
}

}  // namespace plenum::control
