#include "host-sim/dictionary/device_configuration.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <stdexcept>

#include "firmware/canopen/eds.hpp"

namespace plenum::host::dictionary {
namespace {

using canopen::DataType;

constexpr std::string_view kNodeId = "$NODEID+";

/// "0x180", "384" as a data sheet writes a whole number.
std::optional<std::uint32_t> whole_number(std::string_view text, int base = 10) {
  if (text.starts_with("0x") || text.starts_with("0X")) {
    text.remove_prefix(2);
    base = 16;
  }
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// "[1018sub1]" is 1018h:1, "[1000]" 1000h:0; of any other line nothing.
std::optional<ObjectId> section_of(std::string_view line) {
  if (!line.starts_with('[') || !line.ends_with(']')) return std::nullopt;
  line = line.substr(1, line.size() - 2);
  const std::size_t split = line.find("sub");
  const auto index = whole_number(line.substr(0, split), 16);
  const auto sub = split == std::string_view::npos ? 0 : whole_number(line.substr(split + 3), 16);
  if (!index || !sub || *index > 0xFFFF || *sub > 0xFF) return std::nullopt;
  return ObjectId{static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*sub)};
}

/// As the data sheet writes its defaults.
std::string value_text(DataType type, std::uint32_t bits) {
  canopen::TextLine line;
  canopen::put_value(line, type, bits);
  return std::string(line.text());
}

class Writer {
 public:
  Writer(const Commissioning& commissioning, const ObjectValues& values)
      : commissioning_(commissioning), values_(values) {}

  void take(std::string_view line) {
    const auto is = [line](std::string_view key) { return line.starts_with(key); };
    if (line.empty()) {
      end_section();
    } else if (is("[")) {
      section_ = line;
      object_ = section_of(line);
      type_.reset();
    } else if (object_ && is("DataType=")) {
      type_ = static_cast<DataType>(number_in(line, line.find('=') + 1, "a whole number"));
    } else if (object_ && line.find(kNodeId) != std::string_view::npos) {
      return resolve(line);
    } else if (section_ == "[FileInfo]" && info(line)) {
      return;
    }
    put("{}", line);
  }

  /// What stands when the last line was taken.
  std::string text() {
    end_section();
    put("");
    put("[DeviceComissioning]");
    put("NodeID={}", commissioning_.node_id);
    put("NodeName={}", commissioning_.node_name);
    put("Baudrate={}", commissioning_.bit_rate_per_s / 1000);
    put("NetNumber=0");
    put("NetworkName=");
    put("CANopenManager=0");
    put("LSS_SerialNumber=0x{:08X}", commissioning_.serial);
    return text_;
  }

 private:
  template <class... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    text_ += fmt::format(format, std::forward<Args>(args)...) + '\n';
  }

  /// Of the text behind `at` in a line.
  std::uint32_t number_in(std::string_view line, std::size_t at, const char* expected) const {
    const auto number = whole_number(line.substr(at));
    if (!number)
      throw std::invalid_argument(fmt::format("data sheet, {}: '{}', expected {}", section_, line, expected));
    return *number;
  }

  void resolve(std::string_view line) {
    const std::size_t at = line.find(kNodeId);
    const std::uint32_t base = number_in(line, at + kNodeId.size(), "a whole number behind $NODEID+");
    put("{}0x{:08X}", line.substr(0, at), base + commissioning_.node_id);
  }

  /// Lines that tell of the file: returns whether `line` was one that is another's in this file.
  bool info(std::string_view line) {
    const std::string_view key = line.substr(0, line.find('='));
    if (key == "FileName") {
      put("FileName={}", commissioning_.file_name);
      put("LastEDS={}", commissioning_.data_sheet);
    } else if (key == "CreationTime" || key == "ModificationTime") {
      put("{}={:%I:%M%p}", key, commissioning_.created);
    } else if (key == "CreationDate" || key == "ModificationDate") {
      put("{}={:%m-%d-%Y}", key, commissioning_.created);
    } else if (key == "CreatedBy" || key == "ModifiedBy") {
      put("{}=plenum", key);
    } else {
      return false;
    }
    return true;
  }

  void end_section() {
    if (!object_ || !type_) return;
    if (const auto found = values_.find(*object_); found != values_.end())
      put("ParameterValue={}", value_text(*type_, found->second));
    object_.reset();
  }

  const Commissioning& commissioning_;
  const ObjectValues& values_;
  std::string text_;
  std::string section_;
  std::optional<ObjectId> object_;
  std::optional<DataType> type_;
};

}  // namespace

std::string device_configuration(std::string_view eds, const Commissioning& commissioning,
                                 const ObjectValues& values) {
  Writer writer(commissioning, values);
  while (!eds.empty()) {
    const std::size_t end = eds.find('\n');
    writer.take(eds.substr(0, end));
    eds.remove_prefix(end == std::string_view::npos ? eds.size() : end + 1);
  }
  return writer.text();
}

}  // namespace plenum::host::dictionary
