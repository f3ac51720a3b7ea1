#include "board/drivers/gpio_chip.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace plenum::board::drivers {

void refuse_gpio(const GpioLine& line, const std::string& found, const std::string& expected) {
  throw std::runtime_error("gpio:" + line.chip + " " + line.line + ": " + found + ", expected " + expected);
}

void refuse_gpio(const GpioLine& line, int cause) {
  const char* expected = "a line that this chip has, can drive this way, and that no driver or program holds";
  if (cause == EACCES || cause == EPERM)
    expected = "a user who may read and write the chip's character device";
  if (cause == ENOENT || cause == ENODEV || cause == ENOTTY) expected = "the character device of a GPIO chip";
  refuse_gpio(line, std::strerror(cause), expected);
}

std::optional<unsigned> gpio_offset(const std::string& line) noexcept {
  unsigned offset = 0;
  const char* const end = line.data() + line.size();
  const auto [at, error] = std::from_chars(line.data(), end, offset);
  if (error != std::errc{} || at != end) return std::nullopt;
  return offset;
}

std::filesystem::path find_gpio_chip(const GpioLine& line, const GpioLabelOf& label_of,
                                     const std::filesystem::path& devices) {
  if (line.chip.starts_with('/')) return line.chip;
  std::error_code unreadable;
  std::vector<std::filesystem::path> labelled;
  for (const auto& entry : std::filesystem::directory_iterator(devices, unreadable)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("gpiochip")) continue;
    if (name == line.chip) return entry.path();
    if (label_of(entry.path()) == line.chip) labelled.push_back(entry.path());
  }
  std::sort(labelled.begin(), labelled.end());
  if (labelled.empty()) refuse_gpio(line, "no such chip", "a name or label that `gpiodetect` lists");
  if (labelled.size() > 1) {
    refuse_gpio(
        line, std::to_string(labelled.size()) + " chips have this label",
        "the name of one (" + labelled[0].filename().string() + ", " + labelled[1].filename().string() + ")");
  }
  return labelled[0];
}

std::string gpio_place(const std::filesystem::path& chip, unsigned offset) {
  std::error_code unreadable;
  return std::filesystem::weakly_canonical(chip, unreadable).string() + ' ' + std::to_string(offset);
}

}  // namespace plenum::board::drivers
