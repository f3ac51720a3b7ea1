#include "board/drivers/gpio_lines.hpp"

#include <stdexcept>

namespace plenum::board::drivers {

GpioLines::GpioLines(const GpioConfig& config, std::vector<std::string>* missing)
    : valve_power_(take(config.valve_power, GpioUse::output_inactive, missing)),
      emergency_stop_(take(config.emergency_stop, GpioUse::input, missing)),
      fault_lamp_(take(config.fault_lamp, GpioUse::output_inactive, missing)),
      vent_(take(config.vent, GpioUse::output_active, missing)) {}

GpioRequest GpioLines::take(const GpioLine& line, GpioUse use, std::vector<std::string>* missing) {
  try {
    return GpioRequest(line, use);
  } catch (const std::runtime_error& error) {
    if (missing == nullptr) throw;
    missing->emplace_back(error.what());
    gone_ = true;
    return GpioRequest(GpioLine{}, use);
  }
}

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
