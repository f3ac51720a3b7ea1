#include "board/drivers/iio_devices.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>

#include "board/drivers/iio_attribute.hpp"

namespace plenum::board::drivers {
namespace {

namespace fs = std::filesystem;

const fs::path kDevices = "/sys/bus/iio/devices";

bool is_there(const fs::path& path) {
  std::error_code unreadable;
  return fs::exists(path, unreadable);
}

/// What lies in a folder, by name.
std::set<std::string> files_in(const fs::path& folder) {
  std::error_code unreadable;
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder, unreadable))
    files.insert(entry.path().filename().string());
  return files;
}

void add_name(IioEntry& entry, const std::optional<std::string>& name) {
  if (!name || name->empty()) return;
  if (std::find(entry.names.begin(), entry.names.end(), *name) == entry.names.end())
    entry.names.push_back(*name);
}

bool is_called(const IioEntry& entry, const std::string& name) {
  return entry.id == name || std::find(entry.names.begin(), entry.names.end(), name) != entry.names.end();
}

std::string listed(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ", ") + word;
  return list;
}

/// The one entry of this name, which may not be any other's, too.
const IioEntry& only(const std::vector<IioEntry>& entries, const std::string& name, const std::string& where,
                     const std::string& kind) {
  std::vector<const IioEntry*> called;
  std::vector<std::string> all;  // "iio:device0 (ad7606-8, pressure)"
  std::vector<std::string> their_others;
  for (const IioEntry& entry : entries) {
    all.push_back(entry.names.empty() ? entry.id : entry.id + " (" + listed(entry.names) + ")");
    if (!is_called(entry, name)) continue;
    called.push_back(&entry);
    their_others.push_back(entry.id != name || entry.names.empty() ? entry.id : entry.names.front());
  }
  if (called.size() == 1) return *called.front();
  if (!called.empty())
    refuse_iio(where, std::to_string(called.size()) + " " + kind + "s have this name",
               "the label or id of one (" + listed(their_others) + ")");
  refuse_iio(where, "no such " + kind, all.empty() ? "one, but there is none" : "one of " + listed(all));
}

/// The voltages of a device that have a raw number, or a place in its scans. The kernel calls the attributes of a channel by its
/// direction, its id, the name that its driver may give it, and what they are: "in_voltage8_supply_raw".
std::vector<IioEntry> voltages(const fs::path& device, const std::string& direction) {
  std::set<std::string> stems;
  const auto collect = [&](const fs::path& folder, std::string_view end) {
    for (const std::string& file : files_in(folder))
      if (file.starts_with(direction + "_voltage") && file.ends_with(end))
        stems.insert(file.substr(0, file.size() - end.size()));
  };
  collect(device, "_raw");
  collect(iio_scan_elements(device), "_en");

  std::vector<IioEntry> entries;
  for (const std::string& stem : stems) {
    // in_voltage0_mean_raw is an attribute of voltage0 that happens to end alike
    const auto part_of = [&](const IioEntry& whole) { return stem.starts_with(whole.file + "_"); };
    if (std::any_of(entries.begin(), entries.end(), part_of)) continue;
    const std::size_t id = direction.size() + 1;
    const std::size_t end = std::min(stem.find('_', id), stem.size());
    IioEntry entry{.id = stem.substr(id, end - id), .names = {}, .file = stem};
    add_name(entry, stem.substr(std::min(end + 1, stem.size())));
    add_name(entry, attribute_text(device / (stem + "_label")));
    entries.push_back(std::move(entry));
  }
  return entries;
}

double number(const IioChannel& named, const IioVoltage& channel, const char* attribute) {
  const std::optional<double> value = attribute_number(channel.attribute(attribute));
  if (!value) refuse_iio(named, std::string(attribute) + ": " + std::strerror(errno), "a number to be read");
  return *value;
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

fs::path iio_buffer(const fs::path& device) {
  return is_there(device / "buffer0") ? device / "buffer0" : device / "buffer";
}

fs::path iio_scan_elements(const fs::path& device) {
  return is_there(device / "buffer0") ? device / "buffer0" : device / "scan_elements";
}

IioVoltage::IioVoltage(fs::path device, std::string stem)
    : device_(std::move(device)), stem_(std::move(stem)) {}

fs::path IioVoltage::attribute(const std::string& name) const {
  const std::string direction = stem_.substr(0, stem_.find('_'));
  // "in_voltage" of in_voltage8_supply, "in_voltage-voltage" of in_voltage0-voltage1
  std::string type = stem_.substr(0, stem_.find('_', direction.size() + 1));
  std::erase_if(type, [](unsigned char letter) { return std::isdigit(letter) != 0; });
  for (const std::string& begin : {stem_ + "_", type + "_", direction + "_", std::string()})
    if (is_there(device_ / (begin + name))) return device_ / (begin + name);
  return device_ / (stem_ + "_" + name);
}

bool IioVoltage::has(const std::string& name) const {
  return is_there(attribute(name));
}

fs::path IioVoltage::scan_element(const std::string& part) const {
  return iio_scan_elements(device_) / (stem_ + "_" + part);
}

IioDevices::IioDevices() {
  if (!is_there(kDevices))
    refuse_iio("/sys/bus/iio", "no Industrial I/O in this kernel",
               "the driver of a converter (modprobe industrialio, and the converter's module)");
  for (const std::string& file : files_in(kDevices)) {
    IioEntry entry{.id = file, .names = {}, .file = kDevices / file};
    add_name(entry, attribute_text(kDevices / file / "name"));
    add_name(entry, attribute_text(kDevices / file / "label"));
    if (file.starts_with("iio:device")) devices_.push_back(entry);
    if (file.starts_with("trigger")) triggers_.push_back(entry);
  }
}

fs::path IioDevices::device(const std::string& name) const {
  return only(devices_, name, name, "device").file;
}

fs::path IioDevices::trigger(const std::string& name) const {
  return only(triggers_, name, name, "trigger").file;
}

IioVoltage IioDevices::voltage(const IioChannel& named, const std::string& direction,
                               const std::string& kind) const {
  const fs::path folder = device(named.device);
  return {folder, only(voltages(folder, direction), named.channel, named.where(), kind).file};
}

IioScale iio_scale(const IioChannel& named, const IioVoltage& channel) {
  IioScale scale;
  scale.scale_mV = number(named, channel, "scale");
  if (!std::isfinite(scale.scale_mV) || scale.scale_mV == 0.0)
    refuse_iio(named, "scale: no step", "a scale in mV");
  if (channel.has("offset")) scale.offset = number(named, channel, "offset");
  return scale;
}

}  // namespace plenum::board::drivers
