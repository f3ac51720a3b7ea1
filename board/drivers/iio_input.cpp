#include "board/drivers/iio_input.hpp"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <sstream>

#include "board/drivers/iio_attribute.hpp"
#include "board/drivers/scan_format.hpp"

namespace plenum::board::drivers {
namespace {

namespace fs = std::filesystem;

// A device whose rate nobody sets may be as fast as 25 kHz.
constexpr unsigned kFreeRunningBlock = 64;
constexpr unsigned kFreeRunningBlocks = 32;
constexpr double kRateTolerance = 0.01;
constexpr const char* kRate = "sampling_frequency";
constexpr const char* kOversampling = "oversampling_ratio";
constexpr const char* kScale = "scale";
constexpr double kScaleTolerance = 1e-3;  // ranges differ by more, digits by less

/// `attribute`: the kRate of a device, a channel or a trigger.
void set_rate(const fs::path& attribute, unsigned rate_Hz) {
  const std::string where = attribute.parent_path().filename();
  int error = IioAttribute(attribute).put(static_cast<long>(rate_Hz));
  const std::optional<double> actual_Hz = attribute_number(attribute);
  if (error == 0 && !actual_Hz) error = errno;
  if (error != 0) {
    refuse_iio(where, std::string(kRate) + ": " + std::strerror(error),
               "one that this user may set to " + std::to_string(rate_Hz));
  }
  if (!(std::abs(*actual_Hz - rate_Hz) <= kRateTolerance * rate_Hz)) {
    refuse_iio(where,
               std::string(kRate) + ": the device made " + std::to_string(*actual_Hz) + " of " +
                   std::to_string(rate_Hz),
               "a rate that it has");
  }
}

/// From "1 2 4 8", or "[1 1 64]": lowest, step, highest.
bool offers(const std::string& available, unsigned ratio) {
  std::istringstream text(available);
  double number = 0.0;
  if (!available.starts_with('[')) {
    while (text >> number)
      if (number == ratio) return true;
    return false;
  }
  double step = 0.0;
  double highest = 0.0;
  char bracket = 0;
  if (!(text >> bracket >> number >> step >> highest) || step <= 0.0) return false;
  return ratio >= number && ratio <= highest && std::fmod(ratio - number, step) == 0.0;
}

/// `attribute`: the kOversampling of a device or its channels.
void set_oversampling(const std::string& device, const fs::path& attribute, unsigned ratio) {
  const auto refuse = [&](const std::string& found, const std::string& expected) {
    refuse_iio(device, std::string(kOversampling) + ": " + found, expected);
  };
  if (!fs::exists(attribute))
    refuse("no such attribute", "a converter that averages, or no key analog_input.oversampling");
  const std::optional<std::string> available = attribute_text(attribute.string() + "_available");
  if (available && !offers(*available, ratio)) refuse(std::to_string(ratio), "one of " + *available);
  int error = IioAttribute(attribute).put(static_cast<long>(ratio));
  const std::optional<double> actual = attribute_number(attribute);
  if (error == 0 && !actual) error = errno;
  if (error != 0) refuse(std::strerror(error), "one that this user may set to " + std::to_string(ratio));
  if (*actual != ratio)
    refuse("the device made " + std::to_string(std::lround(*actual)) + " of " + std::to_string(ratio),
           "a ratio that it has");
}

/// `channel`: one of those that share the scale.
void set_scale(const std::string& device, const IioVoltage& channel, double scale_mV) {
  const auto refuse = [&](const std::string& found, const std::string& expected) {
    refuse_iio(device, std::string(kScale) + ": " + found, expected);
  };
  const auto same = [&](double one) { return std::abs(one - scale_mV) <= kScaleTolerance * scale_mV; };
  // a channel of its own scale may share the list of those that there are
  const std::optional<std::string> available =
      attribute_text(channel.attribute(std::string(kScale) + "_available"));
  if (!available)
    refuse("no scale_available", "a converter with several ranges, or no key analog_input.scale_mV");
  std::istringstream words(*available);
  std::string word;  // as the kernel writes it: it takes no other
  while (words >> word && !same(std::strtod(word.c_str(), nullptr))) word.clear();
  if (word.empty()) refuse(std::to_string(scale_mV), "one of " + *available);
  const fs::path attribute = channel.attribute(kScale);
  const int error = IioAttribute(attribute).put(word);
  if (error != 0) refuse(std::strerror(error), "one that this user may set to " + word);
  const std::optional<double> actual = attribute_number(attribute);
  if (!actual || !same(*actual)) refuse("the device did not take " + word, "a range that it has");
}

/// /dev/iio:deviceN, which the kernel opens for one program at a time.
class ScanFile {
 public:
  explicit ScanFile(const std::string& id) noexcept
      : file_(::open(("/dev/" + id).c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)),
        error_(file_ < 0 ? errno : 0) {
    // A program that has asked the kernel for a handle of the buffer (IIO_BUFFER_GET_FD_IOCTL) may have closed this file since.
    if (error_ == 0 && ::read(file_, nullptr, 0) < 0 && errno == EBUSY) error_ = EBUSY;
  }
  ~ScanFile() {
    if (file_ >= 0) ::close(file_);
  }
  ScanFile(const ScanFile&) = delete;
  ScanFile& operator=(const ScanFile&) = delete;

  int error() const noexcept { return error_; }
  int descriptor() const noexcept { return file_; }

 private:
  int file_;
  int error_;
};

}  // namespace

/// One device. Nothing of it is changed before claim().
class IioInput::Capture {
 public:
  explicit Capture(const fs::path& device)
      : device_(device), file_(device.filename()), enable_(iio_buffer(device) / "enable") {
    if (file_.error() != 0) refuse_capture(std::strerror(file_.error()));
  }
  ~Capture() {
    if (claimed_) enable_.put(0);
  }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  const fs::path& device() const { return device_; }

  /// Returns the channel's place among the sums.
  std::size_t add(const IioChannel& named, const IioVoltage& channel) {
    const std::optional<double> index = attribute_number(channel.scan_element("index"));
    const std::optional<std::string> type = attribute_text(channel.scan_element("type"));
    if (!index || !type) refuse_iio(named, "no part of the device's scans", "a channel that can be captured");
    const std::optional<SampleFormat> format = sample_format(*type);
    if (!format || !format->is_one_number())
      refuse_iio(named, "samples of " + *type, "one number in 8, 16 or 32 bits");
    const auto twice = [&](const Channel& one) { return one.voltage == channel; };
    if (std::any_of(channels_.begin(), channels_.end(), twice))
      refuse_iio(named, "given twice", "one channel an input");
    channels_.push_back({.voltage = channel, .index = static_cast<unsigned>(*index), .format = *format});
    return channels_.size() - 1;
  }

  /// Ends what a program has left running that was killed: it has closed the device, and the kernel does not mind.
  void claim() {
    claimed_ = true;
    if (const int error = enable_.put(0); error != 0) refuse("enable", error);
  }

  void set_trigger(const fs::path& trigger) {
    const std::string name = attribute_text(trigger / "name").value_or("");
    if (const int error = IioAttribute(current_trigger()).put(name); error != 0) {
      refuse_iio(id(), "trigger " + name + ": " + std::strerror(error),
                 "a trigger that this device admits, and this user may set");
    }
  }

  void set_oversampling(unsigned ratio) const {
    for (const IioVoltage& channel : each_of(kOversampling))
      drivers::set_oversampling(id(), channel.attribute(kOversampling), ratio);
  }

  void set_scale(double scale_mV) const {
    for (const IioVoltage& channel : each_of(kScale)) drivers::set_scale(id(), channel, scale_mV);
  }

  IioScale scale(const IioChannel& named, std::size_t channel) const {
    return iio_scale(named, channels_[channel].voltage);
  }
  std::int64_t highest(std::size_t channel) const noexcept {
    return highest_number(channels_[channel].format);
  }

  void set_rate(const IioDevices& devices, unsigned rate_Hz) const {
    drivers::set_rate(rate_attribute(devices), rate_Hz);
  }

  /// Scans of these channels and nothing else, `blocks` x `block` of them kept, the reader woken after `block`.
  /// `block_is_tick`: that many make a tick.
  void start(unsigned block, unsigned blocks, bool block_is_tick) {
    for (const auto& entry : fs::directory_iterator(iio_scan_elements(device_)))
      if (entry.path().filename().string().ends_with("_en")) put(entry.path(), 0);
    std::vector<ScanElement> elements;
    for (const Channel& one : channels_) {
      put(one.voltage.scan_element("en"), 1);
      elements.push_back({.index = one.index, .bytes = one.format.bytes()});
    }
    const ScanLayout layout = scan_layout(elements);
    for (std::size_t i = 0; i < channels_.size(); ++i) channels_[i].offset = layout.offsets[i];
    scan_bytes_ = layout.size;
    memory_.resize(block * scan_bytes_);
    length_ = block * blocks;
    newest_ = block_is_tick ? block : length_;
    put(iio_buffer(device_) / "length", length_);
    put(iio_buffer(device_) / "watermark", block);
    if (const int error = enable_.put(1); error != 0) refuse("enable", error);
  }

  int descriptor() const noexcept { return file_.descriptor(); }

  /// Takes what waits; of more than a tick's worth the newest. False: as much as the kernel's buffer was asked to hold was there.
  /// A full one drops what comes and keeps what came first, so that nobody knows how old that is: nothing of it counts.
  bool take() noexcept {
    unsigned taken = 0;
    // The kernel may round the length of its buffer up, at most to twice as much.
    while (!gone_ && taken < 2 * length_) {
      const std::size_t room = memory_.size() - held_;
      const ssize_t bytes = ::read(file_.descriptor(), memory_.data() + held_, room);
      if (bytes < 0 && errno == EINTR) continue;
      if (bytes < 0 && errno == EAGAIN) break;
      if (bytes <= 0) {
        gone_ = true;
        break;
      }
      held_ += static_cast<std::size_t>(bytes);
      if (scans_ >= newest_ && static_cast<std::size_t>(bytes) == room) begin();
      taken += add_scans();
      if (static_cast<std::size_t>(bytes) < room) break;
    }
    if (taken < length_) return true;
    begin();
    return false;
  }

  bool gone() const noexcept { return gone_; }
  unsigned scans() const noexcept { return scans_; }
  /// Of the raw numbers since begin().
  double mean(std::size_t channel) const noexcept {
    return static_cast<double>(channels_[channel].sum) / scans_;
  }
  /// None of the raw numbers since begin() was below the highest.
  bool at_end(std::size_t channel) const noexcept {
    return channels_[channel].sum == highest(channel) * static_cast<std::int64_t>(scans_);
  }
  void begin() noexcept {
    scans_ = 0;
    for (Channel& one : channels_) one.sum = 0;
  }

 private:
  struct Channel {
    IioVoltage voltage;
    unsigned index;
    SampleFormat format;
    std::size_t offset = 0;  ///< [bytes] in a scan
    std::int64_t sum = 0;    ///< of 32-bit numbers: of years of them
  };

  std::string id() const { return device_.filename(); }

  /// A channel for each attribute of this name: several may share one.
  std::vector<IioVoltage> each_of(const char* name) const {
    std::vector<IioVoltage> found;
    for (const Channel& one : channels_) {
      const auto shares = [&](const IioVoltage& other) {
        return other.attribute(name) == one.voltage.attribute(name);
      };
      if (std::none_of(found.begin(), found.end(), shares)) found.push_back(one.voltage);
    }
    return found;
  }

  [[noreturn]] void refuse_capture(const std::string& found) const {
    refuse_iio(
        id(), "capture: " + found,
        "a device that has a trigger, that no other program captures from, and that is open to this user");
  }
  [[noreturn]] void refuse(const std::string& attribute, int error) const {
    refuse_capture(attribute + ": " + std::strerror(error));
  }

  void put(const fs::path& attribute, unsigned value) const {
    const int error = IioAttribute(attribute).put(static_cast<long>(value));
    if (error != 0) refuse(attribute.filename(), error);
  }

  fs::path current_trigger() const { return device_ / "trigger" / "current_trigger"; }

  /// Where the rate of this device's scans is set.
  fs::path rate_attribute(const IioDevices& devices) const {
    std::vector<fs::path> places;
    if (const std::string name = attribute_text(current_trigger()).value_or(""); !name.empty())
      places.push_back(devices.trigger(name) / kRate);
    places.push_back(device_ / kRate);
    for (const Channel& one : channels_) places.push_back(one.voltage.attribute(kRate));
    for (const fs::path& one : places)
      if (fs::exists(one)) return one;
    refuse_iio(
        id(), std::string("no attribute ") + kRate,
        "one of the device, its channels or its trigger, or rate_Hz = 0 for a device that runs freely");
  }

  /// Adds the whole scans in the memory to the sums, and keeps the beginning of one. The kernel gives whole ones.
  unsigned add_scans() noexcept {
    const std::size_t scans = held_ / scan_bytes_;
    const std::byte* const end = memory_.data() + scans * scan_bytes_;
    for (Channel& one : channels_) {
      for (const std::byte* scan = memory_.data(); scan < end; scan += scan_bytes_)
        one.sum += raw_number(one.format, scan + one.offset);
    }
    held_ -= scans * scan_bytes_;
    std::copy_n(end, held_, memory_.begin());
    scans_ += static_cast<unsigned>(scans);
    return static_cast<unsigned>(scans);
  }

  fs::path device_;
  ScanFile file_;
  IioAttribute enable_;
  std::vector<Channel> channels_;
  std::vector<std::byte> memory_;  ///< a block of scans
  std::size_t held_ = 0;           ///< [bytes] of it that are no whole scan yet
  std::size_t scan_bytes_ = 1;
  unsigned length_ = 0;  ///< [scans]
  unsigned newest_ = 0;  ///< [scans] after which a whole block that waits takes the place of those before
  unsigned scans_ = 0;
  bool claimed_ = false;
  bool gone_ = false;
};

IioInput::IioInput(const IioInputConfig& config) : scans_per_tick_(config.rate_Hz / kTicks_Hz) {
  if (config.rate_Hz % kTicks_Hz != 0) {
    refuse_iio("rate_Hz", std::to_string(config.rate_Hz), "a multiple of " + std::to_string(kTicks_Hz));
  }
  const IioDevices devices;
  for (const IioChannel& named : config.channels) places_.push_back(place(devices, named));
  for (const auto& capture : captures_) capture->claim();
  set_up(devices, config);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Place& one = places_[i];
    if (one.device != nullptr) one.scale = one.device->scale(config.channels[i], one.sum);
  }
  for (const auto& capture : captures_) {
    if (scans_per_tick_ != 0) {
      capture->start(scans_per_tick_, kBufferTicks, true);
    } else {
      capture->start(kFreeRunningBlock, kFreeRunningBlocks, false);
    }
    descriptors_.push_back(capture->descriptor());
  }
}

IioInput::~IioInput() = default;

IioInput::Place IioInput::place(const IioDevices& devices, const IioChannel& named) {
  if (!named.fitted()) return {};
  const IioVoltage channel = devices.input(named);
  const auto known = std::find_if(captures_.begin(), captures_.end(),
                                  [&](const auto& capture) { return capture->device() == channel.device(); });
  Capture& capture = known != captures_.end()
                         ? **known
                         : *captures_.emplace_back(std::make_unique<Capture>(channel.device()));
  return {&capture, capture.add(named, channel), {}};
}

double IioInput::end_V(std::size_t channel) const noexcept {
  const Place& place = places_[channel];
  return place.scale.volts(static_cast<double>(place.device->highest(place.sum)));
}

// The oversampling comes before the rate: on some converters it bounds that.
void IioInput::set_up(const IioDevices& devices, const IioInputConfig& config) {
  if (config.scale_mV) {
    for (const auto& capture : captures_) capture->set_scale(*config.scale_mV);
  }
  if (config.oversampling) {
    for (const auto& capture : captures_) capture->set_oversampling(*config.oversampling);
  }
  if (!config.trigger.empty()) {
    const std::filesystem::path trigger = devices.trigger(config.trigger);
    for (const auto& capture : captures_) capture->set_trigger(trigger);
  }
  for (const auto& capture : captures_) {
    if (config.rate_Hz != 0) capture->set_rate(devices, config.rate_Hz);
  }
}

void IioInput::gather() noexcept {
  for (std::size_t i = 0; i < captures_.size(); ++i) {
    if (!captures_[i]->take()) ++overflows_;
    if (captures_[i]->gone()) descriptors_[i] = -1;
  }
}

void IioInput::forget() noexcept {
  gather();
  for (const auto& capture : captures_) capture->begin();
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
    const Capture& device = *places_[i].device;
    const double mean_V = places_[i].scale.volts(device.mean(places_[i].sum));
    readings[i] = {
        .mean_V = static_cast<float>(mean_V), .fresh = true, .at_end = device.at_end(places_[i].sum)};
  }
  for (const auto& capture : captures_) capture->begin();
}

bool IioInput::gone() const noexcept {
  return std::any_of(captures_.begin(), captures_.end(), [](const auto& one) { return one->gone(); });
}

}  // namespace plenum::board::drivers
