// How a configuration names a line, and which character device that is. Knows no libgpiod.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace plenum::board::drivers {

struct GpioLine {
  std::string chip;         ///< "gpiochip0", "/dev/gpiochip0", or the chip's label; empty: not fitted
  std::string line;         ///< name, or offset on the chip ("3")
  bool active_low = false;  ///< active when the pin is low

  bool fitted() const noexcept { return !chip.empty(); }
};

/// Throws std::runtime_error "gpio:<chip> <line>: <found>, expected <expected>".
[[noreturn]] void refuse_gpio(const GpioLine& line, const std::string& found, const std::string& expected);

/// The same when a call has failed with `cause` (errno).
[[noreturn]] void refuse_gpio(const GpioLine& line, int cause);

/// Empty: `line` is a name.
std::optional<unsigned> gpio_offset(const std::string& line) noexcept;

/// The label of the chip at a path; empty when it cannot be opened.
using GpioLabelOf = std::function<std::optional<std::string>(const std::filesystem::path&)>;

/// The character device of the line's chip: a path, a name in `devices`, or the one chip there whose label it is.
std::filesystem::path find_gpio_chip(const GpioLine& line, const GpioLabelOf& label_of,
                                     const std::filesystem::path& devices = "/dev");

/// "/dev/gpiochip0 3": the same for every name of a line.
std::string gpio_place(const std::filesystem::path& chip, unsigned offset);

}  // namespace plenum::board::drivers
