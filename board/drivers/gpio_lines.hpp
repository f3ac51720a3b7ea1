// The digital lines of the board, through the kernel's GPIO character devices (libgpiod 1.6 or 2.x).
//
// A line's value here is logical: active is 1, and `active_low` says that the pin is then low. Wire so that no current is the
// safe side: an emergency stop circuit that opens at a broken wire, a relay and a vent valve that fall off by themselves. What
// a pin does after the last process has let it go is the controller's affair, so the board's resistors must be safe, too.
#pragma once

#include <string>
#include <vector>

#include "board/drivers/gpio_request.hpp"
#include "firmware/ports/digital_io.hpp"

namespace plenum::board::drivers {

struct GpioConfig {
  GpioLine valve_power;     ///< output, active: the valves have their supply
  GpioLine emergency_stop;  ///< input, active: the circuit is open
  GpioLine fault_lamp;      ///< output
  GpioLine vent;            ///< output, active: the dump valve is open; it is whenever the valve power is off
};

class GpioLines final : public ports::DigitalIo {
 public:
  /// Takes the lines: valve power off, vent open, lamp off. Throws std::runtime_error: where, what was found, expected.
  /// With `missing` it throws nothing: what cannot be taken is told there and counts as a line that is gone, the others are
  /// taken.
  explicit GpioLines(const GpioConfig& config, std::vector<std::string>* missing = nullptr);
  /// Valve power off, vent open; the lamp stays.
  ~GpioLines();
  GpioLines(const GpioLines&) = delete;
  GpioLines& operator=(const GpioLines&) = delete;

  /// The emergency stop is reported when it is active now, or was at any time since the last read. From the first line that
  /// cannot be read or written any more it is reported for good.
  ports::DigitalInputs read() noexcept override;
  void write(const ports::DigitalOutputs& outputs) noexcept override;

  /// To poll for POLLIN: the emergency stop has changed, until the next read(). -1: not fitted, or gone.
  int descriptor() const noexcept { return gone_ ? -1 : emergency_stop_.descriptor(); }

  /// A line could not be read or written.
  bool gone() const noexcept { return gone_; }

 private:
  GpioRequest take(const GpioLine& line, GpioUse use, std::vector<std::string>* missing);
  void set_power(bool on) noexcept;

  bool gone_ = false;
  GpioRequest valve_power_;
  GpioRequest emergency_stop_;
  GpioRequest fault_lamp_;
  GpioRequest vent_;
};

}  // namespace plenum::board::drivers
