#include "board/drivers/iio_output.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "board/drivers/iio_attribute.hpp"

namespace plenum::board::drivers {
namespace {

/// Open for writing.
IioAttribute to_write(const IioChannel& named, const std::filesystem::path& path) {
  IioAttribute attribute(path);
  if (attribute.error() != 0) {
    refuse_iio(named, path.string() + ": " + std::strerror(attribute.error()),
               "an attribute that this user may write");
  }
  return attribute;
}

struct RawRange {  // an attribute of the kernel is an int
  double lowest = std::numeric_limits<int>::min();
  double highest = std::numeric_limits<int>::max();

  /// But for the step to full scale.
  bool reaches(double code) const noexcept {
    return std::round(code) >= lowest - 1.0 && std::round(code) <= highest + 1.0;
  }
};

/// From "[0 1 65535]": lowest, step, highest. Few drivers state it.
RawRange raw_range(const IioChannel& named, const IioVoltage& channel) {
  RawRange range;
  if (!channel.has("raw_available")) return range;
  const std::string text = attribute_text(channel.attribute("raw_available")).value_or("");
  double step = 0.0;
  if (std::sscanf(text.c_str(), "[%lf %lf %lf]", &range.lowest, &step, &range.highest) != 3 ||
      range.lowest >= range.highest)
    refuse_iio(named, "raw_available: " + text, "[lowest step highest]");
  return range;
}

}  // namespace

struct IioOutput::Output {
  std::size_t index;  ///< in the configuration
  IioScale scale;
  RawRange range;
  double safe_V;
  IioAttribute raw;
  std::optional<IioAttribute> powerdown;
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
    const IioDevices devices;
    std::vector<IioVoltage> taken;
    for (std::size_t i = 0; i < config.channels.size(); ++i) {
      if (!config.channels[i].fitted()) continue;
      attempt([&] { outputs_.push_back(opened(devices, config.channels[i], i, config.safe_V[i], taken)); });
    }
  });
}

IioOutput::Output IioOutput::opened(const IioDevices& devices, const IioChannel& named, std::size_t index,
                                    float safe_V, std::vector<IioVoltage>& taken) {
  const IioVoltage channel = devices.output(named);
  if (std::find(taken.begin(), taken.end(), channel) != taken.end()) {
    refuse_iio(named, "given twice", "one channel an output");
  }
  taken.push_back(channel);
  if (!std::isfinite(safe_V)) refuse_iio(named, "safe_V is no number", "volts");
  Output output{.index = index,
                .scale = iio_scale(named, channel),
                .range = raw_range(named, channel),
                .safe_V = static_cast<double>(safe_V),
                .raw = to_write(named, channel.attribute("raw")),
                .powerdown = std::nullopt};
  if (!output.range.reaches(output.scale.raw(output.safe_V))) {
    refuse_iio(named, "safe_V lies beyond the converter's range", "a value that it can hold");
  }
  if (channel.has("powerdown")) output.powerdown.emplace(to_write(named, channel.attribute("powerdown")));
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

bool IioOutput::reaches(std::size_t channel, float volts) const noexcept {
  return std::none_of(outputs_.begin(), outputs_.end(), [&](const Output& output) {
    return output.index == channel && !output.range.reaches(output.scale.raw(static_cast<double>(volts)));
  });
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
