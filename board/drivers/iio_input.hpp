// Analog inputs through the kernel's Industrial I/O subsystem: buffered capture, averaged into one reading a tick.
//
// Each device that the channels name gets one buffer. A scan is one sample of every channel in use on it, taken together
// where the chip samples together (AD7606). The kernel stores the scans; gather() takes what waits and sums it, read() hands
// the means over and begins the next tick. The descriptors become readable when a tick's worth of scans is there, so that
// the converter can pace the ticks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "board/drivers/iio_devices.hpp"
#include "firmware/config/limits.hpp"
#include "firmware/ports/analog.hpp"

namespace plenum::board::drivers {

inline constexpr unsigned kTicks_Hz = 1'000'000 / plenum::config::kTick_us;

struct IioInputConfig {
  std::vector<IioChannel> channels;  ///< in the order of kAnalogInputs: 8 pressures, 8 positions, supply
  /// Name or id; empty: the device has its own, or needs none.
  std::string trigger;
  /// Scans a second, a multiple of 100, set where there is an attribute sampling_frequency: of the trigger, the device or its
  /// channels. 0: none is set; a device that runs freely (AD7606, paced by its own busy line) brings what it brings, and
  /// cannot pace the ticks.
  unsigned rate_Hz = 1000;
  /// Conversions that the converter averages to a sample, of every device: its attribute oversampling_ratio. Empty: left as it is.
  std::optional<unsigned> oversampling{};
  /// [mV] a step, of every channel: one of its attribute scale_available, by which converters tell their ranges. Empty: left as it is.
  std::optional<double> scale_mV{};
};

class IioInput final : public ports::AnalogInput {
 public:
  /// Kernel buffer, in ticks: what may pass without gather() before scans are lost.
  static constexpr unsigned kBufferTicks = 8;

  /// Sets scale, oversampling, trigger and rate, and starts the capture. Throws std::runtime_error: where, what was found, what was expected.
  explicit IioInput(const IioInputConfig& config);
  ~IioInput();
  IioInput(const IioInput&) = delete;
  IioInput& operator=(const IioInput&) = delete;

  /// One a device, to poll for POLLIN. Readable: a tick's worth of scans waits, or the device has gone. -1: it is known to.
  std::span<const int> descriptors() const noexcept { return descriptors_; }

  /// Takes what waits and adds it to the tick's sums, of several ticks' scans those of the last. Never waits.
  void gather() noexcept;

  /// What has come up to now is of no tick.
  void forget() noexcept;

  /// Scans since the last read() that every device has brought: the least of the devices'.
  unsigned gathered() const noexcept;

  /// Scans in a tick at the rate asked for; 0: the devices run freely.
  unsigned scans_per_tick() const noexcept { return scans_per_tick_; }

  /// gather(), then the mean of each channel since the last read(). A channel without a scan, or not fitted, is not fresh.
  void read(std::span<ports::AnalogReading> readings) noexcept override;

  /// The most that the converter of a channel that is fitted can tell [V].
  double end_V(std::size_t channel) const noexcept;

  /// A device was removed, or refuses to be read: its channels stay not fresh.
  bool gone() const noexcept;

  /// Times that kBufferTicks of scans or more were waiting in one buffer: scans may have been lost. The kernel drops them
  /// without a word, so this is all that can be known; those that waited are dropped, too. Wraps.
  std::uint32_t overflows() const noexcept { return overflows_; }

 private:
  class Capture;  // one device

  struct Place {
    Capture* device = nullptr;  ///< null: not fitted
    std::size_t sum = 0;        ///< which of the device's
    IioScale scale;
  };

  Place place(const IioDevices& devices, const IioChannel& named);
  void set_up(const IioDevices& devices, const IioInputConfig& config);

  std::vector<std::unique_ptr<Capture>> captures_;
  std::vector<Place> places_;  ///< of each channel
  std::vector<int> descriptors_;
  unsigned scans_per_tick_ = 0;
  std::uint32_t overflows_ = 0;
};

}  // namespace plenum::board::drivers
