// libgpiod 1.6.
#include <gpiod.h>

#include <array>
#include <cerrno>
#include <ctime>

#include "board/drivers/gpio_request.hpp"

namespace plenum::board::drivers {
namespace {

constexpr const char* kConsumer = "plenumd";
constexpr const char* kUnnamed = "somebody without a name";

struct CloseChip {
  void operator()(gpiod_chip* chip) const noexcept { ::gpiod_chip_close(chip); }  // releases its lines, too
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

std::optional<std::string> label_of(const std::filesystem::path& path) {
  const Chip chip(::gpiod_chip_open(path.c_str()));
  if (!chip) return std::nullopt;
  return ::gpiod_chip_label(chip.get());
}

Chip chip_of(const GpioLine& line) {
  Chip chip(::gpiod_chip_open(find_gpio_chip(line, label_of).c_str()));
  if (!chip) refuse_gpio(line, errno);
  return chip;
}

/// The chip's.
gpiod_line& line_of(const GpioLine& line, gpiod_chip& chip) {
  const std::optional<unsigned> offset = gpio_offset(line.line);
  gpiod_line* const found =
      offset ? ::gpiod_chip_get_line(&chip, *offset) : ::gpiod_chip_find_line(&chip, line.line.c_str());
  if (found == nullptr) refuse_gpio(line, "no such line", "a name or an offset that `gpioinfo` lists");
  return *found;
}

int request(gpiod_line* line, bool active_low, GpioUse use) {
  const int flags = active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  const gpiod_line_request_config as_is{
      .consumer = kConsumer, .request_type = GPIOD_LINE_REQUEST_DIRECTION_AS_IS, .flags = flags};
  if (use == GpioUse::as_is) return ::gpiod_line_request(line, &as_is, 0);
  if (use == GpioUse::input) return ::gpiod_line_request_both_edges_events_flags(line, kConsumer, flags);
  return ::gpiod_line_request_output_flags(line, kConsumer, flags, use == GpioUse::output_active ? 1 : 0);
}

}  // namespace

GpioInfo gpio_info(const GpioLine& line) {
  const Chip chip = chip_of(line);
  gpiod_line& found = line_of(line, *chip);
  GpioInfo info{.holder = "",
                .output = ::gpiod_line_direction(&found) == GPIOD_LINE_DIRECTION_OUTPUT,
                .place = gpio_place(find_gpio_chip(line, label_of), ::gpiod_line_offset(&found))};
  if (::gpiod_line_is_used(&found)) {
    const char* const consumer = ::gpiod_line_consumer(&found);
    info.holder = consumer != nullptr ? consumer : kUnnamed;
  }
  return info;
}

struct GpioRequest::Handle {
  Chip chip;
  gpiod_line* line = nullptr;  ///< the chip's
  bool input = false;
};

GpioRequest::GpioRequest(const GpioLine& line, GpioUse use) {
  if (!line.fitted()) return;
  handle_ = std::make_unique<Handle>();
  handle_->chip = chip_of(line);
  handle_->line = &line_of(line, *handle_->chip);
  if (request(handle_->line, line.active_low, use) != 0) refuse_gpio(line, errno);
  handle_->input = use == GpioUse::input;
}

GpioRequest::~GpioRequest() = default;

std::optional<bool> GpioRequest::value() noexcept {
  if (!handle_) return false;
  const int value = ::gpiod_line_get_value(handle_->line);
  if (value < 0) return std::nullopt;
  return value == 1;
}

bool GpioRequest::set(bool active) noexcept {
  return !handle_ || ::gpiod_line_set_value(handle_->line, active ? 1 : 0) == 0;
}

std::optional<bool> GpioRequest::take_change() noexcept {
  bool changed = false;
  for (int i = 0; handle_ && i < kReadsAtOnce; ++i) {
    const timespec now{};
    const int waiting = ::gpiod_line_event_wait(handle_->line, &now);
    if (waiting == 0) break;
    std::array<gpiod_line_event, kEventsAtOnce> events{};
    if (waiting < 0 || ::gpiod_line_event_read_multiple(handle_->line, events.data(),
                                                        static_cast<unsigned>(events.size())) < 0)
      return std::nullopt;
    changed = true;
  }
  return changed;
}

int GpioRequest::descriptor() const noexcept {
  return handle_ && handle_->input ? ::gpiod_line_event_get_fd(handle_->line) : -1;
}

}  // namespace plenum::board::drivers
