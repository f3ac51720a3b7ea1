// Analog outputs through the kernel's Industrial I/O subsystem: out_voltageN_raw, with the kernel's scale and offset.
//
// The converter holds a value until the next one, also when nobody is left to write it. So make_safe() is called before the
// first tick, by the destructor, and, for a process that dies without one, by its guard (board/guard.hpp).
#pragma once

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "board/drivers/iio_devices.hpp"
#include "firmware/ports/analog.hpp"

namespace plenum::board::drivers {

struct IioOutputConfig {
  std::vector<IioChannel> channels;  ///< in the order of the chambers
  std::vector<float> safe_V;         ///< one a channel
  /// Where safe values that may change stand, one a channel; must outlive the output. Empty: safe_V, for good.
  std::span<const std::atomic<float>> safe_now_V{};
};

class IioOutput final : public ports::AnalogOutput {
 public:
  /// Opens the outputs and writes nothing. Throws std::runtime_error: where, what was found, what was expected.
  /// With `missing` it throws only for a configuration that is none: an output that cannot be opened is told there, and
  /// counts as one that refuses every value; the others are opened.
  explicit IioOutput(const IioOutputConfig& config, std::vector<std::string>* missing = nullptr);
  /// Makes safe what was written to.
  ~IioOutput();
  IioOutput(const IioOutput&) = delete;
  IioOutput& operator=(const IioOutput&) = delete;

  /// Sets each output [V], clipped to the raw range where the kernel states it (raw_available). Every output is tried; a
  /// command that is not finite becomes the safe value. False: a command was none, lies more than a step beyond the range,
  /// or the device refused one.
  bool write(std::span<const float> command_V) noexcept override;

  /// Whether write() would take that for this channel, as far as the kernel states the range; true of one that is not fitted or open.
  bool reaches(std::size_t channel, float volts) const noexcept;

  /// Sets every output to its safe value, and powers up those that start powered down. False: the device refused one.
  bool make_safe() noexcept;

 private:
  struct Output;

  double safe_V(const Output& output) const noexcept;
  /// Adds the channel to those `taken`.
  static Output opened(const IioDevices& devices, const IioChannel& named, std::size_t index, float safe_V,
                       std::vector<IioVoltage>& taken);

  std::vector<Output> outputs_;  ///< those that are fitted
  std::span<const std::atomic<float>> safe_now_V_;
  bool all_open_ = true;
  bool driven_ = false;
};

}  // namespace plenum::board::drivers
