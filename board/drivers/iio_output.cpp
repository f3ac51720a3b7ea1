#include "board/drivers/iio_output.hpp"

#include <fcntl.h>
#include <iio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace plenum::board::drivers {
namespace {

/// An attribute, open for writing. Kept open, a value costs one system call and no look-up.
class Attribute {
 public:
  Attribute(const IioChannel& named, const iio_channel& channel, const char* attribute) {
    const char* const name = ::iio_channel_attr_get_filename(&channel, attribute);
    if (name == nullptr)
      refuse_iio(named, std::string("no attribute ") + attribute, "an output that has one");
    const std::string path = std::string("/sys/bus/iio/devices/") +
                             ::iio_device_get_id(::iio_channel_get_device(&channel)) + "/" + name;
    file_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (file_ < 0) {
      refuse_iio(named, path + ": " + std::strerror(errno), "an attribute that this user may write");
    }
  }
  Attribute(Attribute&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  ~Attribute() {
    if (file_ >= 0) ::close(file_);
  }

  /// 0, or the kernel's error.
  int put(long value) const noexcept {
    std::array<char, 24> text{};
    char* const end = std::to_chars(text.begin(), text.end() - 1, value).ptr;
    *end = '\n';
    const std::size_t size = static_cast<std::size_t>(end - text.begin()) + 1;
    ssize_t count = 0;
    do {
      count = ::pwrite(file_, text.data(), size, 0);
    } while (count < 0 && errno == EINTR);
    return count < 0 ? errno : 0;
  }

 private:
  int file_ = -1;
};

struct RawRange {  // an attribute of the kernel is an int
  double lowest = std::numeric_limits<int>::min();
  double highest = std::numeric_limits<int>::max();

  /// But for the step to full scale.
  bool reaches(double code) const noexcept {
    return std::round(code) >= lowest - 1.0 && std::round(code) <= highest + 1.0;
  }
};

/// From "[0 1 65535]": lowest, step, highest. Few drivers state it.
RawRange raw_range(const IioChannel& named, const iio_channel& channel) {
  RawRange range;
  if (::iio_channel_find_attr(&channel, "raw_available") == nullptr) return range;
  std::array<char, 128> text{};
  const ssize_t size = ::iio_channel_attr_read(&channel, "raw_available", text.data(), text.size());
  double step = 0.0;
  if (size < 0 || std::sscanf(text.data(), "[%lf %lf %lf]", &range.lowest, &step, &range.highest) != 3 ||
      range.lowest >= range.highest)
    refuse_iio(named, std::string("raw_available: ") + text.data(), "[lowest step highest]");
  return range;
}

}  // namespace

struct IioOutput::Output {
  std::size_t index;  ///< in the configuration
  IioScale scale;
  RawRange range;
  double safe_V;
  Attribute raw;
  std::optional<Attribute> powerdown;
  bool powered = false;

  bool set(double volts) noexcept;
};

/// A converter's full scale lies one step past its last code, and few drivers state that code. So what the kernel refuses as
/// out of its range is tried once more, one step nearer to zero.
bool IioOutput::Output::set(double volts) noexcept {
  const double asked = scale.raw(volts);
  const long code = std::lround(std::clamp(asked, range.lowest, range.highest));
  int error = raw.put(code);
  if (error == EINVAL || error == ERANGE) error = raw.put(code > 0 ? code - 1 : code + 1);
  if (error == 0 && !powered) {
    if (powerdown) error = powerdown->put(0);
    powered = error == 0;
  }
  return error == 0 && range.reaches(asked);
}

IioOutput::IioOutput(const IioOutputConfig& config, std::vector<std::string>* missing)
    : safe_now_V_(config.safe_now_V) {
  if (config.safe_V.size() != config.channels.size()) {
    refuse_iio("outputs", std::to_string(config.safe_V.size()) + " safe values",
               "one for each of the " + std::to_string(config.channels.size()) + " channels");
  }
  const auto attempt = [&](auto&& open) {
    try {
      open();
    } catch (const std::runtime_error& error) {
      if (missing == nullptr) throw;
      missing->emplace_back(error.what());
      all_open_ = false;
    }
  };
  attempt([&] {
    const IioContext context;
    std::vector<const iio_channel*> taken;
    for (std::size_t i = 0; i < config.channels.size(); ++i) {
      if (!config.channels[i].fitted()) continue;
      attempt([&] { outputs_.push_back(opened(context, config.channels[i], i, config.safe_V[i], taken)); });
    }
  });
}

IioOutput::Output IioOutput::opened(const IioContext& context, const IioChannel& named, std::size_t index,
                                    float safe_V, std::vector<const iio_channel*>& taken) {
  const iio_channel& channel = context.output(named);
  if (std::find(taken.begin(), taken.end(), &channel) != taken.end()) {
    refuse_iio(named, "given twice", "one channel an output");
  }
  taken.push_back(&channel);
  if (!std::isfinite(safe_V)) refuse_iio(named, "safe_V is no number", "volts");
  Output output{.index = index,
                .scale = iio_scale(named, channel),
                .range = raw_range(named, channel),
                .safe_V = static_cast<double>(safe_V),
                .raw = Attribute(named, channel, "raw"),
                .powerdown = std::nullopt};
  if (!output.range.reaches(output.scale.raw(output.safe_V))) {
    refuse_iio(named, "safe_V lies beyond the converter's range", "a value that it can hold");
  }
  if (::iio_channel_find_attr(&channel, "powerdown") != nullptr) {
    output.powerdown.emplace(named, channel, "powerdown");
  }
  return output;
}

IioOutput::~IioOutput() {
  if (driven_) make_safe();
}

double IioOutput::safe_V(const Output& output) const noexcept {
  if (output.index >= safe_now_V_.size()) return output.safe_V;
  return static_cast<double>(safe_now_V_[output.index].load(std::memory_order_relaxed));
}

bool IioOutput::write(std::span<const float> command_V) noexcept {
  driven_ = true;
  bool all = all_open_;
  for (Output& output : outputs_) {
    if (output.index >= command_V.size()) continue;
    const auto command = static_cast<double>(command_V[output.index]);
    const bool sane = std::isfinite(command);
    const bool done = output.set(sane ? command : safe_V(output));
    all = all && sane && done;
  }
  return all;
}

bool IioOutput::make_safe() noexcept {
  driven_ = true;
  bool all = all_open_;
  for (Output& output : outputs_) {
    const bool done = output.set(safe_V(output));
    all = all && done;
  }
  return all;
}

}  // namespace plenum::board::drivers
