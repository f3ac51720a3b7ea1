// One line of a GPIO chip, taken from the kernel. The only place that knows libgpiod: gpio_request_v1.cpp is built against
// 1.6, gpio_request_v2.cpp against 2.x.
#pragma once

#include <memory>
#include <optional>
#include <string>

namespace plenum::board::drivers {

struct GpioLine {
  std::string chip;         ///< "gpiochip0", "/dev/gpiochip0", or the chip's label; empty: not fitted
  std::string line;         ///< name, or offset on the chip ("3")
  bool active_low = false;  ///< active when the pin is low

  bool fitted() const noexcept { return !chip.empty(); }
};

enum class GpioUse {
  input,            ///< with an event at every change
  output_inactive,  ///< inactive until set
  output_active     ///< active until set
};

class GpioRequest {
 public:
  /// Of a line that is not fitted nothing is taken: it reads as inactive, and every set() succeeds.
  /// Throws std::runtime_error: which line, what was found, what was expected.
  GpioRequest(const GpioLine& line, GpioUse use);
  ~GpioRequest();
  GpioRequest(const GpioRequest&) = delete;
  GpioRequest& operator=(const GpioRequest&) = delete;

  /// True when active; empty when the line cannot be read.
  std::optional<bool> value() noexcept;
  /// False when the line cannot be written.
  bool set(bool active) noexcept;
  /// Whether an input has changed since the last call, however briefly; empty when its events cannot be read. Never waits.
  std::optional<bool> take_change() noexcept;
  /// To poll for POLLIN: take_change() would say true. -1: not fitted.
  int descriptor() const noexcept;

 private:
  struct Handle;
  std::unique_ptr<Handle> handle_;  ///< null: not fitted
};

}  // namespace plenum::board::drivers
