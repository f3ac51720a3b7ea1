#include "firmware/control/inverse_check.hpp"

namespace plenum::control {
namespace {

/// The `index`th of `count` values at equal distances.
Scalar among(Scalar low, Scalar high, std::size_t index, std::size_t count) noexcept {
  return low + (high - low) * Scalar(static_cast<int>(index)) / Scalar(static_cast<int>(count - 1));
}

}  // namespace

InverseCheck::Finding InverseCheck::step(const PressureModel& model) noexcept {
  for (std::size_t i = 0; i < kPointsPerTick && next_ < kPoints; ++i) {
    const Finding found = look_at(model, next_++);
    if (found != Finding::passed) return found;
  }
  return next_ < kPoints ? Finding::running : Finding::passed;
}

InverseCheck::Finding InverseCheck::look_at(const PressureModel& model, std::size_t number) noexcept {
  const std::size_t command = number % kCommands;
  const std::size_t pressure = number / kCommands % kPressures;
  const std::size_t volume = number / (kCommands * kPressures);
  point_ = {.pressure_kPa = among(range_.pressure_low_kPa, range_.pressure_high_kPa, pressure, kPressures),
            .volume_mL = among(range_.volume_low_mL, range_.volume_high_mL, volume, kVolumes),
            .command_V = among(range_.command_low_V, range_.command_high_V, command, kCommands)};
  const Moving still = model.moving({.volume_mL = point_.volume_mL, .volume_rate_mL_s = Scalar(0)});
  const auto end_of_tick_kPa = [&](Scalar command_V) noexcept {
    return model.step(point_.pressure_kPa, model.opening(command_V), still, Scalar(1)).end_kPa;
  };
  const Scalar end_kPa = end_of_tick_kPa(point_.command_V);

  if (pressure == kPressures / 2 && (command == 0 || command == kCommands - 1)) {
    const Scalar least_kPa = range_.span_kPa / kTicksOfSpan;
    const bool up = command != 0;
    const Scalar moved_kPa = up ? end_kPa - point_.pressure_kPa : point_.pressure_kPa - end_kPa;
    point_.wanted_kPa = up ? point_.pressure_kPa + least_kPa : point_.pressure_kPa - least_kPa;
    point_.came_kPa = end_kPa;
    if (!(moved_kPa >= least_kPa)) return Finding::no_authority;
  }
  const Scalar from_V = Scalar(0.5) * (range_.command_low_V + range_.command_high_V);
  const Inverse answer = model.inverse(point_.pressure_kPa, end_kPa, still, from_V);
  point_.wanted_kPa = end_kPa;
  point_.came_kPa = end_of_tick_kPa(answer.command_V);
  const bool came = numeric::abs(point_.came_kPa - end_kPa) <= kTolerance * range_.span_kPa;
  return came ? Finding::passed : Finding::inverse_fails;
}

}  // namespace plenum::control
