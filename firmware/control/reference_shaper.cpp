#include "firmware/control/reference_shaper.hpp"

#include "firmware/config/limits.hpp"

namespace plenum::control {

void ReferenceShaper::configure(const Config& config) noexcept {
  config_ = config;
  rise_kPa_ = config.rise_kPa_s * Scalar(config::kTick_s);
  fall_kPa_ = config.fall_kPa_s * Scalar(config::kTick_s);
}

void ReferenceShaper::reset(Scalar pressure_kPa) noexcept {
  reference_.kPa.fill(pressure_kPa);
  latched_kPa_.fill(pressure_kPa);
  newest_ = 0;
}

const ReferenceShaper::Reference& ReferenceShaper::step(Scalar setpoint_kPa, std::uint8_t preview_ticks,
                                                        std::size_t ahead) noexcept {
  const std::uint32_t next = newest_ - 1;
  newest_ = next < kKept ? next : kKept - 1;  // none beyond, whatever has flipped
  latched_kPa_[newest_] = numeric::clamp(setpoint_kPa, config_.low_kPa, config_.high_kPa);
  limit_touched_ = setpoint_kPa > Scalar(0) && latched_kPa_[newest_] != setpoint_kPa;

  // A set point with preview N is the reference N ticks after its own tick's start: the one for the end of the i-th tick
  // from now was latched N - i ticks ago. Without preview the newest set point is wanted as soon as can be: at this tick's
  // end.
  const std::size_t preview = preview_ticks < kMaxPreview ? preview_ticks : kMaxPreview;
  std::array<Scalar, kMostAhead + 1>& kPa = reference_.kPa;
  kPa[0] = kPa[1];
  for (std::size_t i = 1; i <= ahead; ++i) {
    const Scalar wanted_kPa = latched_kPa(i < preview ? preview - i : 0);
    kPa[i] = numeric::clamp(wanted_kPa, kPa[i - 1] - fall_kPa_, kPa[i - 1] + rise_kPa_);
  }
  ramp_runs_ = kPa[1] != latched_kPa(preview > 1 ? preview - 1 : 0);
  return reference_;
}

}  // namespace plenum::control
