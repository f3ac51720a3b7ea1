#include "board/drivers/iio_input.hpp"

#include <fcntl.h>
#include <iio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace plenum::board::drivers {
namespace {

// A device whose rate nobody sets may be as fast as 25 kHz.
constexpr unsigned kFreeRunningBlock = 64;
constexpr unsigned kFreeRunningBlocks = 32;
constexpr double kRateTolerance = 0.01;
constexpr const char* kRate = "sampling_frequency";

struct CloseBuffer {
  void operator()(iio_buffer* buffer) const noexcept { ::iio_buffer_destroy(buffer); }
};

template <class Stored>
std::int64_t converted(const iio_channel& channel, const void* at) noexcept {
  Stored raw{};
  ::iio_channel_convert(&channel, &raw, at);
  return raw;
}

/// The number that a scan holds for a channel: byte order, shift, and sign as the kernel states them.
std::int64_t raw_number(const iio_channel& channel, const void* at) noexcept {
  const iio_data_format& format = *::iio_channel_get_data_format(&channel);
  switch (format.length) {
    case 8:
      return format.is_signed ? converted<std::int8_t>(channel, at) : converted<std::uint8_t>(channel, at);
    case 16:
      return format.is_signed ? converted<std::int16_t>(channel, at) : converted<std::uint16_t>(channel, at);
    default:
      return format.is_signed ? converted<std::int32_t>(channel, at) : converted<std::uint32_t>(channel, at);
  }
}

/// An attribute `sampling_frequency`, of whatever has one.
struct Rate {
  std::string where;
  const iio_device* device = nullptr;
  const iio_channel* channel = nullptr;  ///< not null: of this channel

  int write(unsigned rate_Hz) const {
    return channel != nullptr ? ::iio_channel_attr_write_longlong(channel, kRate, rate_Hz)
                              : ::iio_device_attr_write_longlong(device, kRate, rate_Hz);
  }
  int read(double& rate_Hz) const {
    return channel != nullptr ? ::iio_channel_attr_read_double(channel, kRate, &rate_Hz)
                              : ::iio_device_attr_read_double(device, kRate, &rate_Hz);
  }
  void set(unsigned rate_Hz) const {
    const auto check = [&](int error) {
      if (error < 0) {
        refuse_iio(where, std::string(kRate) + ": " + std::strerror(-error),
                   "one that this user may set to " + std::to_string(rate_Hz));
      }
    };
    double actual_Hz = 0.0;
    check(write(rate_Hz));
    check(read(actual_Hz));
    if (!(std::abs(actual_Hz - rate_Hz) <= kRateTolerance * rate_Hz)) {
      refuse_iio(where,
                 std::string(kRate) + ": the device made " + std::to_string(actual_Hz) + " of " +
                     std::to_string(rate_Hz),
                 "a rate that it has");
    }
  }
};

}  // namespace

class IioInput::Capture {
 public:
  /// Changes nothing of a device that another program captures from: libiio would end that capture before it finds the
  /// device taken.
  explicit Capture(iio_device& device) : device_(device), name_(::iio_device_get_id(&device)) {
    const int file = ::open(("/dev/" + name_).c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) refuse_capture(errno);
    ::close(file);
  }

  const iio_device* device() const { return &device_; }

  /// Returns the channel's place among the sums.
  std::size_t add(const IioChannel& named, iio_channel& channel) {
    if (!::iio_channel_is_scan_element(&channel)) {
      refuse_iio(named, "no part of the device's scans", "a channel that can be captured");
    }
    const iio_data_format& format = *::iio_channel_get_data_format(&channel);
    const bool held = format.length == 8 || format.length == 16 || format.length == 32;
    if (!held || format.repeat > 1) {
      refuse_iio(named,
                 std::to_string(format.repeat) + " x " + std::to_string(format.length) + " bits a sample",
                 "1 x 8, 16 or 32");
    }
    const auto twice = [&](const Channel& one) { return one.channel == &channel; };
    if (std::any_of(channels_.begin(), channels_.end(), twice)) {
      refuse_iio(named, "given twice", "one channel an input");
    }
    ::iio_channel_enable(&channel);
    channels_.push_back({&channel, 0});
    return channels_.size() - 1;
  }

  void set_trigger(const iio_device& trigger) {
    if (const int error = ::iio_device_set_trigger(&device_, &trigger); error < 0) {
      refuse_iio(name_,
                 std::string("trigger ") + ::iio_device_get_name(&trigger) + ": " + std::strerror(-error),
                 "a trigger that this device admits, and this user may set");
    }
  }

  /// Where the rate of this device's scans is set.
  Rate rate() const {
    const iio_device* trigger = nullptr;
    if (::iio_device_get_trigger(&device_, &trigger) == 0 && trigger != nullptr &&
        ::iio_device_find_attr(trigger, kRate) != nullptr) {
      return {::iio_device_get_id(trigger), trigger, nullptr};
    }
    if (::iio_device_find_attr(&device_, kRate) != nullptr) return {name_, &device_, nullptr};
    for (const Channel& one : channels_) {
      if (::iio_channel_find_attr(one.channel, kRate) != nullptr) return {name_, &device_, one.channel};
    }
    refuse_iio(
        name_, std::string("no attribute ") + kRate,
        "one of the device, its channels or its trigger, or rate_Hz = 0 for a device that runs freely");
  }

  void start(unsigned block, unsigned blocks) {
    block_ = block;
    length_ = block * blocks;
    const int error = ::iio_device_set_kernel_buffers_count(&device_, blocks);
    if (error == 0) buffer_.reset(::iio_device_create_buffer(&device_, block, false));
    const int cause = error == 0 ? errno : -error;
    if (!buffer_ || ::iio_buffer_set_blocking_mode(buffer_.get(), false) != 0) {
      refuse_capture(cause);
    }
  }

  int descriptor() const noexcept { return ::iio_buffer_get_poll_fd(buffer_.get()); }

  /// Takes what waits. False: as much as the kernel's buffer was asked to hold was there.
  bool take() noexcept {
    unsigned taken = 0;
    // The kernel may round the length of its buffer up, at most to twice as much.
    while (!gone_ && taken < 2 * length_) {
      const ssize_t bytes = ::iio_buffer_refill(buffer_.get());
      if (bytes == -EAGAIN) break;
      if (bytes <= 0) {
        gone_ = true;
        break;
      }
      const unsigned scans = add_scans();
      taken += scans;
      if (scans < block_) break;
    }
    return taken < length_;
  }

  bool gone() const noexcept { return gone_; }
  unsigned scans() const noexcept { return scans_; }
  /// Of the raw numbers since begin().
  double mean(std::size_t channel) const noexcept {
    return static_cast<double>(channels_[channel].sum) / scans_;
  }
  void begin() noexcept {
    scans_ = 0;
    for (Channel& one : channels_) one.sum = 0;
  }

 private:
  [[noreturn]] void refuse_capture(int cause) const {
    refuse_iio(
        name_, std::string("capture: ") + std::strerror(cause),
        "a device that has a trigger, that no other program captures from, and that is open to this user");
  }

  struct Channel {
    const iio_channel* channel;
    std::int64_t sum;  ///< of 32-bit numbers: of years of them
  };

  unsigned add_scans() noexcept {
    const char* const end = static_cast<const char*>(::iio_buffer_end(buffer_.get()));
    const char* const start = static_cast<const char*>(::iio_buffer_start(buffer_.get()));
    const std::ptrdiff_t step = ::iio_buffer_step(buffer_.get());
    for (Channel& one : channels_) {
      const char* at = static_cast<const char*>(::iio_buffer_first(buffer_.get(), one.channel));
      for (; at < end; at += step) one.sum += raw_number(*one.channel, at);
    }
    const auto scans = static_cast<unsigned>((end - start) / step);
    scans_ += scans;
    return scans;
  }

  iio_device& device_;
  std::string name_;
  std::vector<Channel> channels_;
  std::unique_ptr<iio_buffer, CloseBuffer> buffer_;
  unsigned block_ = 0;
  unsigned length_ = 0;
  unsigned scans_ = 0;
  bool gone_ = false;
};

IioInput::IioInput(const IioInputConfig& config) : scans_per_tick_(config.rate_Hz / kTicks_Hz) {
  if (config.rate_Hz % kTicks_Hz != 0) {
    refuse_iio("rate_Hz", std::to_string(config.rate_Hz), "a multiple of " + std::to_string(kTicks_Hz));
  }
  for (const IioChannel& named : config.channels) places_.push_back(place(named));
  set_pace(config);
  for (const auto& capture : captures_) {
    if (scans_per_tick_ != 0) {
      capture->start(scans_per_tick_, kBufferTicks);
    } else {
      capture->start(kFreeRunningBlock, kFreeRunningBlocks);
    }
    descriptors_.push_back(capture->descriptor());
  }
}

IioInput::~IioInput() = default;

IioInput::Place IioInput::place(const IioChannel& named) {
  if (!named.fitted()) return {};
  iio_channel& channel = context_.input(named);
  iio_device& device = context_.device(named.device);
  const auto known = std::find_if(captures_.begin(), captures_.end(),
                                  [&](const auto& capture) { return capture->device() == &device; });
  Capture& capture =
      known != captures_.end() ? **known : *captures_.emplace_back(std::make_unique<Capture>(device));
  const IioScale scale = iio_scale(named, channel);
  return {&capture, capture.add(named, channel), scale};
}

void IioInput::set_pace(const IioInputConfig& config) {
  if (!config.trigger.empty()) {
    const iio_device& trigger = context_.device(config.trigger);
    if (!::iio_device_is_trigger(&trigger))
      refuse_iio(config.trigger, "no trigger", "one that `iio_info` lists");
    for (const auto& capture : captures_) capture->set_trigger(trigger);
  }
  for (const auto& capture : captures_) {
    if (config.rate_Hz != 0) capture->rate().set(config.rate_Hz);
  }
}

void IioInput::gather() noexcept {
  for (std::size_t i = 0; i < captures_.size(); ++i) {
    if (!captures_[i]->take()) ++overflows_;
    if (captures_[i]->gone()) descriptors_[i] = -1;
  }
}

unsigned IioInput::gathered() const noexcept {
  if (captures_.empty()) return 0;
  const auto fewer = [](const auto& a, const auto& b) { return a->scans() < b->scans(); };
  return (*std::min_element(captures_.begin(), captures_.end(), fewer))->scans();
}

void IioInput::read(std::span<ports::AnalogReading> readings) noexcept {
  gather();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    readings[i] = {};
    if (i >= places_.size() || places_[i].device == nullptr || places_[i].device->scans() == 0) continue;
    const double mean_V = places_[i].scale.volts(places_[i].device->mean(places_[i].sum));
    readings[i] = {.mean_V = static_cast<float>(mean_V), .fresh = true};
  }
  for (const auto& capture : captures_) capture->begin();
}

bool IioInput::gone() const noexcept {
  return std::any_of(captures_.begin(), captures_.end(), [](const auto& one) { return one->gone(); });
}

}  // namespace plenum::board::drivers
