#include "board/drivers/gpio_lines.hpp"

namespace plenum::board::drivers {

GpioLines::GpioLines(const GpioConfig& config)
    : valve_power_(config.valve_power, GpioUse::output_inactive),
      emergency_stop_(config.emergency_stop, GpioUse::input),
      fault_lamp_(config.fault_lamp, GpioUse::output_inactive),
      vent_(config.vent, GpioUse::output_active) {}

GpioLines::~GpioLines() {
  set_power(false);
}

ports::DigitalInputs GpioLines::read() noexcept {
  const std::optional<bool> changed = emergency_stop_.take_change();
  const std::optional<bool> active = emergency_stop_.value();
  if (!changed || !active) gone_ = true;
  return {.emergency_stop = gone_ || *changed || *active};
}

void GpioLines::write(const ports::DigitalOutputs& outputs) noexcept {
  set_power(outputs.valve_power);
  if (!fault_lamp_.set(outputs.fault_lamp)) gone_ = true;
}

void GpioLines::set_power(bool on) noexcept {
  const bool switched = valve_power_.set(on);
  const bool vented = vent_.set(!on);
  if (!switched || !vented) gone_ = true;
}

}  // namespace plenum::board::drivers
