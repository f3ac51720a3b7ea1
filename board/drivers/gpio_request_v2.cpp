// libgpiod 2.x.
#include <gpiod.h>

#include <cerrno>

#include "board/drivers/gpio_request.hpp"

namespace plenum::board::drivers {
namespace {

constexpr const char* kConsumer = "plenumd";
constexpr const char* kUnnamed = "somebody without a name";

template <auto function>
struct Free {
  template <class T>
  void operator()(T* object) const noexcept {
    function(object);
  }
};
template <class T, auto function>
using Owned = std::unique_ptr<T, Free<function>>;

using Chip = Owned<gpiod_chip, ::gpiod_chip_close>;
using ChipInfo = Owned<gpiod_chip_info, ::gpiod_chip_info_free>;
using LineInfo = Owned<gpiod_line_info, ::gpiod_line_info_free>;
using LineSettings = Owned<gpiod_line_settings, ::gpiod_line_settings_free>;
using LineConfig = Owned<gpiod_line_config, ::gpiod_line_config_free>;
using RequestConfig = Owned<gpiod_request_config, ::gpiod_request_config_free>;
using Request = Owned<gpiod_line_request, ::gpiod_line_request_release>;
using Events = Owned<gpiod_edge_event_buffer, ::gpiod_edge_event_buffer_free>;

std::optional<std::string> label_of(const std::filesystem::path& path) {
  const Chip chip(::gpiod_chip_open(path.c_str()));
  if (!chip) return std::nullopt;
  const ChipInfo info(::gpiod_chip_get_info(chip.get()));
  if (!info) return std::nullopt;
  return ::gpiod_chip_info_get_label(info.get());
}

Chip chip_of(const GpioLine& line) {
  Chip chip(::gpiod_chip_open(find_gpio_chip(line, label_of).c_str()));
  if (!chip) refuse_gpio(line, errno);
  return chip;
}

unsigned offset_of(const GpioLine& line, gpiod_chip& chip) {
  if (const std::optional<unsigned> offset = gpio_offset(line.line)) return *offset;
  const int offset = ::gpiod_chip_get_line_offset_from_name(&chip, line.line.c_str());
  if (offset < 0) refuse_gpio(line, "no such line", "a name or an offset that `gpioinfo` lists");
  return static_cast<unsigned>(offset);
}

/// Null: errno says why.
Request request(gpiod_chip& chip, unsigned offset, bool active_low, GpioUse use) {
  const LineSettings settings(::gpiod_line_settings_new());
  const LineConfig lines(::gpiod_line_config_new());
  const RequestConfig how(::gpiod_request_config_new());
  if (!settings || !lines || !how) return nullptr;
  ::gpiod_request_config_set_consumer(how.get(), kConsumer);
  ::gpiod_line_settings_set_active_low(settings.get(), active_low);
  const gpiod_line_value value =
      use == GpioUse::output_active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
  const bool input = use == GpioUse::input;
  const bool set =
      use == GpioUse::as_is
          ? ::gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_AS_IS) == 0
      : input ? ::gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT) == 0 &&
                    ::gpiod_line_settings_set_edge_detection(settings.get(), GPIOD_LINE_EDGE_BOTH) == 0
              : ::gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT) == 0 &&
                    ::gpiod_line_settings_set_output_value(settings.get(), value) == 0;
  if (!set || ::gpiod_line_config_add_line_settings(lines.get(), &offset, 1, settings.get()) != 0)
    return nullptr;
  return Request(::gpiod_chip_request_lines(&chip, how.get(), lines.get()));
}

}  // namespace

GpioInfo gpio_info(const GpioLine& line) {
  const Chip chip = chip_of(line);
  const unsigned offset = offset_of(line, *chip);
  const LineInfo found(::gpiod_chip_get_line_info(chip.get(), offset));
  if (!found) refuse_gpio(line, errno);
  GpioInfo info{.holder = "",
                .output = ::gpiod_line_info_get_direction(found.get()) == GPIOD_LINE_DIRECTION_OUTPUT,
                .place = gpio_place(find_gpio_chip(line, label_of), offset)};
  if (::gpiod_line_info_is_used(found.get())) {
    const char* const consumer = ::gpiod_line_info_get_consumer(found.get());
    info.holder = consumer != nullptr ? consumer : kUnnamed;
  }
  return info;
}

struct GpioRequest::Handle {
  Request request;
  Events events;  ///< null: an output
  unsigned offset = 0;
};

GpioRequest::GpioRequest(const GpioLine& line, GpioUse use) {
  if (!line.fitted()) return;
  const Chip chip = chip_of(line);
  handle_ = std::make_unique<Handle>();
  handle_->offset = offset_of(line, *chip);
  handle_->request = request(*chip, handle_->offset, line.active_low, use);
  if (!handle_->request) refuse_gpio(line, errno);
  if (use != GpioUse::input) return;
  handle_->events.reset(::gpiod_edge_event_buffer_new(kEventsAtOnce));
  if (!handle_->events) refuse_gpio(line, errno);
}

GpioRequest::~GpioRequest() = default;

std::optional<bool> GpioRequest::value() noexcept {
  if (!handle_) return false;
  const gpiod_line_value value = ::gpiod_line_request_get_value(handle_->request.get(), handle_->offset);
  if (value == GPIOD_LINE_VALUE_ERROR) return std::nullopt;
  return value == GPIOD_LINE_VALUE_ACTIVE;
}

bool GpioRequest::set(bool active) noexcept {
  const gpiod_line_value value = active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
  return !handle_ || ::gpiod_line_request_set_value(handle_->request.get(), handle_->offset, value) == 0;
}

std::optional<bool> GpioRequest::take_change() noexcept {
  bool changed = false;
  for (int i = 0; handle_ && i < kReadsAtOnce; ++i) {
    const int waiting = ::gpiod_line_request_wait_edge_events(handle_->request.get(), 0);
    if (waiting == 0) break;
    if (waiting < 0 || ::gpiod_line_request_read_edge_events(handle_->request.get(), handle_->events.get(),
                                                             kEventsAtOnce) < 0)
      return std::nullopt;
    changed = true;
  }
  return changed;
}

int GpioRequest::descriptor() const noexcept {
  return handle_ && handle_->events ? ::gpiod_line_request_get_fd(handle_->request.get()) : -1;
}

}  // namespace plenum::board::drivers
