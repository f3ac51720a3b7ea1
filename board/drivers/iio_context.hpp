// The Industrial I/O devices of this machine, as the kernel lists them under /sys/bus/iio/devices: what both the inputs and
// the outputs look their channels up in.
#pragma once

#include <memory>
#include <string>

struct iio_channel;
struct iio_context;
struct iio_device;

namespace plenum::board::drivers {

/// Where one voltage comes from or goes to. Both empty: not fitted.
struct IioChannel {
  std::string
      device;  ///< name ("ad7606-8"), label, or id ("iio:device0"); only label and id tell equal chips apart
  std::string channel;  ///< "voltage0", or the name that the kernel gives it

  bool fitted() const noexcept { return !device.empty() || !channel.empty(); }
  std::string where() const;  ///< for messages
  friend bool operator==(const IioChannel&, const IioChannel&) = default;
};

/// Every error is a std::runtime_error: where, what was found, what was expected.
class IioContext {
 public:
  IioContext();

  /// The one device or trigger of this name, label or id; more than one is an error.
  iio_device& device(const std::string& name) const;
  /// The device's channel in the direction asked for, not null.
  iio_channel& input(const IioChannel& named) const { return channel(named, false); }
  iio_channel& output(const IioChannel& named) const { return channel(named, true); }

 private:
  struct Close {
    void operator()(iio_context* context) const noexcept;
  };

  iio_channel& channel(const IioChannel& named, bool output) const;

  std::unique_ptr<iio_context, Close> context_;
};

/// What turns a channel's raw number into volts at the pin: (raw + offset) x scale_mV / 1000.
struct IioScale {
  double scale_mV = 1.0;  ///< [mV] a step
  double offset = 0.0;    ///< [steps]

  double volts(double raw) const noexcept { return (raw + offset) * scale_mV / 1000.0; }
  double raw(double volts) const noexcept { return volts * 1000.0 / scale_mV - offset; }
};

/// From the channel's attributes `scale` and, where there is one, `offset`. Throws when the scale is missing or zero.
IioScale iio_scale(const IioChannel& named, const iio_channel& channel);

/// Throws std::runtime_error "iio:<where>: <found>, expected <expected>".
[[noreturn]] void refuse_iio(const std::string& where, const std::string& found, const std::string& expected);
[[noreturn]] void refuse_iio(const IioChannel& where, const std::string& found, const std::string& expected);

}  // namespace plenum::board::drivers
