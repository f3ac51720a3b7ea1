// The Industrial I/O devices of this machine: folders of attributes that the kernel lists under /sys/bus/iio/devices. What both
// the inputs and the outputs look their channels up in. Names are the kernel's (Documentation/ABI/testing/sysfs-bus-iio).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plenum::board::drivers {

/// Where one voltage comes from or goes to. Both empty: not fitted.
struct IioChannel {
  std::string
      device;  ///< name ("ad7606-8"), label, or id ("iio:device0"); only label and id tell equal chips apart
  /// Id ("voltage0", differential "voltage0-voltage1"), or the name or label that the kernel gives it.
  std::string channel;

  bool fitted() const noexcept { return !device.empty() || !channel.empty(); }
  std::string where() const;  ///< for messages
  friend bool operator==(const IioChannel&, const IioChannel&) = default;
};

/// A voltage of a device, found: where its attributes are.
class IioVoltage {
 public:
  /// `stem`: what the names of its own attributes begin with ("in_voltage0", "in_voltage8_supply").
  IioVoltage(std::filesystem::path device, std::string stem);

  const std::filesystem::path& device() const noexcept { return device_; }
  /// An attribute of its own, or else the one that it shares with its type (in_voltage_scale), its direction (in_scale) or the
  /// whole device (scale). Where the kernel has none of these: its own.
  std::filesystem::path attribute(const std::string& name) const;
  bool has(const std::string& name) const;
  /// `part`: "en", "index" or "type".
  std::filesystem::path scan_element(const std::string& part) const;
  friend bool operator==(const IioVoltage&, const IioVoltage&) = default;

 private:
  std::filesystem::path device_;
  std::string stem_;
};

/// Where a device has what is said of its buffer and of the elements of its scans. From kernel 5.11 on both are in `buffer0`,
/// and the two folders of before, which hold the same, are marked to be removed one day.
std::filesystem::path iio_buffer(const std::filesystem::path& device);
std::filesystem::path iio_scan_elements(const std::filesystem::path& device);

/// Something to be looked up.
struct IioEntry {
  std::string id;
  std::vector<std::string> names;  ///< others than its id, which it may share
  std::string file;                ///< a device's folder, a channel's stem
};

/// Every error is a std::runtime_error: where, what was found, what was expected.
class IioDevices {
 public:
  IioDevices();

  /// The folder of the one device of this name, label or id; more than one is an error.
  std::filesystem::path device(const std::string& name) const;
  /// The same of a trigger, which has no label.
  std::filesystem::path trigger(const std::string& name) const;
  IioVoltage input(const IioChannel& named) const { return voltage(named, "in", "input"); }
  IioVoltage output(const IioChannel& named) const { return voltage(named, "out", "output"); }

 private:
  IioVoltage voltage(const IioChannel& named, const std::string& direction, const std::string& kind) const;

  std::vector<IioEntry> devices_;
  std::vector<IioEntry> triggers_;
};

/// What turns a channel's raw number into volts at the pin: (raw + offset) x scale_mV / 1000.
struct IioScale {
  double scale_mV = 1.0;  ///< [mV] a step
  double offset = 0.0;    ///< [steps]

  double volts(double raw) const noexcept { return (raw + offset) * scale_mV / 1000.0; }
  double raw(double volts) const noexcept { return volts * 1000.0 / scale_mV - offset; }
};

/// From the channel's attributes `scale` and, where there is one, `offset`. Throws when the scale is missing or zero.
IioScale iio_scale(const IioChannel& named, const IioVoltage& channel);

/// Throws std::runtime_error "iio:<where>: <found>, expected <expected>".
[[noreturn]] void refuse_iio(const std::string& where, const std::string& found, const std::string& expected);
[[noreturn]] void refuse_iio(const IioChannel& where, const std::string& found, const std::string& expected);

}  // namespace plenum::board::drivers
