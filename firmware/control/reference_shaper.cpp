#include "firmware/control/reference_shaper.hpp"

#include "firmware/config/limits.hpp"

namespace plenum::control {

void ReferenceShaper::reset(Scalar pressure_kPa) noexcept {
  now_kPa_ = pressure_kPa;
  latched_kPa_.fill(pressure_kPa);
}

ReferenceShaper::Reference ReferenceShaper::step(Scalar setpoint_kPa, std::uint8_t preview_ticks) noexcept {
  for (std::size_t i = kMaxPreview; i > 0; --i) latched_kPa_[i] = latched_kPa_[i - 1];
  latched_kPa_[0] = numeric::clamp(setpoint_kPa, config_.low_kPa, config_.high_kPa);

  // A set point with preview N is the reference N ticks after its own tick's start: the one for this tick's
  // end was latched N - 1 ticks ago. Without preview the newest set point is wanted as soon as can be: at
  // this tick's end.
  const std::size_t preview = preview_ticks < kMaxPreview ? preview_ticks : kMaxPreview;
  const std::size_t next = preview == 0 ? 0 : preview - 1;
  const std::size_t after = next == 0 ? 0 : next - 1;
  const Scalar step_kPa = config_.ramp_kPa_s * Scalar(config::kTick_s);
  const auto toward = [step_kPa](Scalar from_kPa, Scalar to_kPa) noexcept {
    return numeric::clamp(to_kPa, from_kPa - step_kPa, from_kPa + step_kPa);
  };
  Reference reference;
  reference.now_kPa = now_kPa_;
  reference.next_kPa = toward(reference.now_kPa, latched_kPa_[next]);
  reference.after_kPa = toward(reference.next_kPa, latched_kPa_[after]);
  now_kPa_ = reference.next_kPa;
  return reference;
}

}  // namespace plenum::control
