// One line of a GPIO chip, taken from the kernel. The only place that knows libgpiod: gpio_request_v1.cpp is built against
// 1.6, gpio_request_v2.cpp against 2.x.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "board/drivers/gpio_chip.hpp"

namespace plenum::board::drivers {

enum class GpioUse {
  input,            ///< with an event at every change
  output_inactive,  ///< inactive until set
  output_active,    ///< active until set
  as_is             ///< to be read: direction and level stay, now and when it is let go
};

/// What the kernel says of a line that nobody takes for that.
struct GpioInfo {
  std::string holder;   ///< the program or driver that has it; empty: it is free
  bool output = false;  ///< it drives its pin
  std::string place;    ///< chip and offset, whatever the line was named by
};

/// Throws as GpioRequest; `line` is fitted.
GpioInfo gpio_info(const GpioLine& line);

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
  // A line that chatters keeps no tick: events beyond these stay for the next call.
  static constexpr int kReadsAtOnce = 4;
  static constexpr unsigned kEventsAtOnce = 16;

  struct Handle;
  std::unique_ptr<Handle> handle_;  ///< null: not fitted
};

}  // namespace plenum::board::drivers
