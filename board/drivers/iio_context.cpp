#include "board/drivers/iio_context.hpp"

#include <iio.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace plenum::board::drivers {
namespace {

bool is_called(const iio_device& device, const std::string& name) {
  const auto names = {::iio_device_get_id(&device), ::iio_device_get_name(&device),
                      ::iio_device_get_label(&device)};
  return std::any_of(names.begin(), names.end(),
                     [&](const char* one) { return one != nullptr && name == one; });
}

double number(const IioChannel& named, const iio_channel& channel, const char* attribute) {
  double value = 0.0;
  const int error = ::iio_channel_attr_read_double(&channel, attribute, &value);
  if (error < 0)
    refuse_iio(named, std::string(attribute) + ": " + std::strerror(-error), "a number to be read");
  return value;
}

}  // namespace

std::string IioChannel::where() const {
  return device + " " + channel;
}

void refuse_iio(const std::string& where, const std::string& found, const std::string& expected) {
  throw std::runtime_error("iio:" + where + ": " + found + ", expected " + expected);
}

void refuse_iio(const IioChannel& where, const std::string& found, const std::string& expected) {
  refuse_iio(where.where(), found, expected);
}

void IioContext::Close::operator()(iio_context* context) const noexcept {
  ::iio_context_destroy(context);
}

IioContext::IioContext() : context_(::iio_create_local_context()) {
  if (!context_) {
    const bool none = errno == ENOENT || errno == ENOSYS || errno == ENODEV;
    refuse_iio("/sys/bus/iio", none ? "no Industrial I/O in this kernel" : std::strerror(errno),
               "the driver of a converter (modprobe industrialio, and the converter's module)");
  }
}

iio_device& IioContext::device(const std::string& name) const {
  std::vector<iio_device*> called;
  for (unsigned i = 0; i < ::iio_context_get_devices_count(context_.get()); ++i) {
    iio_device* const one = ::iio_context_get_device(context_.get(), i);
    if (is_called(*one, name)) called.push_back(one);
  }
  if (called.empty()) refuse_iio(name, "no such device", "a name, label or id that `iio_info` lists");
  if (called.size() > 1) {
    refuse_iio(name, std::to_string(called.size()) + " devices have this name",
               std::string("the label or id of one (") + ::iio_device_get_id(called[0]) + ", " +
                   ::iio_device_get_id(called[1]) + ")");
  }
  return *called[0];
}

iio_channel& IioContext::channel(const IioChannel& named, bool output) const {
  iio_channel* const found = ::iio_device_find_channel(&device(named.device), named.channel.c_str(), output);
  if (found == nullptr) {
    refuse_iio(named, output ? "no such output" : "no such input", "a channel that `iio_info` lists");
  }
  if (::iio_channel_get_type(found) != IIO_VOLTAGE) refuse_iio(named, "no voltage", "a voltage channel");
  return *found;
}

IioScale iio_scale(const IioChannel& named, const iio_channel& channel) {
  IioScale scale;
  scale.scale_mV = number(named, channel, "scale");
  if (!std::isfinite(scale.scale_mV) || scale.scale_mV == 0.0)
    refuse_iio(named, "scale: no step", "a scale in mV");
  if (::iio_channel_find_attr(&channel, "offset") != nullptr) scale.offset = number(named, channel, "offset");
  return scale;
}

}  // namespace plenum::board::drivers
