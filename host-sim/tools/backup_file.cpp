#include "host-sim/tools/backup_file.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <limits>
#include <set>
#include <stdexcept>

#include "host-sim/tools/board_json.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::tools {
namespace {

constexpr const char* kSchema = "plenum-backup/1";

std::string hex_of(std::span<const std::uint8_t> bytes) {
  return fmt::format("{:02X}", fmt::join(bytes, ""));
}

/// Reads the fields of a file, and says where one is not as expected.
class Fields {
 public:
  Fields(const Json& json, std::string where) : json_(json), where_(std::move(where)) {
    if (!json.is_object()) throw trace::InputError(fmt::format("{}: expected an object", where_));
  }
  const Json& at(const char* name) const {
    const auto found = json_.find(name);
    if (found == json_.end())
      throw trace::InputError(fmt::format("{}: field '{}' is missing, expected it", where_, name));
    return *found;
  }
  const Json& list(const char* name) const {
    const Json& found = at(name);
    if (!found.is_array()) refuse(name, "a list");
    return found;
  }
  std::uint32_t whole(const char* name, std::uint32_t low = 0, std::uint32_t high = 0xFFFF'FFFFU) const {
    const Json& found = at(name);
    if (!found.is_number_unsigned() || found.get<std::uint64_t>() < low ||
        found.get<std::uint64_t>() > high) {
      refuse(name, fmt::format("a whole number of {}..{}", low, high));
    }
    return found.get<std::uint32_t>();
  }
  std::string text(const char* name) const {
    const Json& found = at(name);
    if (!found.is_string()) refuse(name, "text");
    return found.get<std::string>();
  }
  /// "8250h"
  std::uint32_t hex_number(const char* name, std::uint32_t high) const {
    const std::string found = text(name);
    std::uint32_t value = 0;
    const char* last = found.data() + found.size() - (found.empty() ? 0 : 1);
    const auto [end, error] = std::from_chars(found.data(), last, value, 16);
    if (found.size() < 2 || found.back() != 'h' || error != std::errc() || end != last || value > high) {
      refuse(name, "a hexadecimal number with an h behind it");
    }
    return value;
  }
  [[noreturn]] void refuse(const char* name, const std::string& expected) const {
    throw trace::InputError(
        fmt::format("{}: field '{}' is {}, expected {}", where_, name, at(name).dump(), expected));
  }
  const std::string& where() const { return where_; }

 private:
  const Json& json_;
  std::string where_;
};

client::Setting setting_of(const Fields& fields) {
  client::Setting setting;
  setting.id.index = static_cast<std::uint16_t>(fields.hex_number("index", 0xFFFF));
  setting.id.sub = static_cast<std::uint8_t>(fields.whole("sub", 0, 0xFF));
  setting.name = fields.text("name");
  const Json& value = fields.at("value");
  try {
    setting.type = client::type_of(fields.text("type"));
    const bool is_beyond =
        value.is_number_unsigned() &&
        value.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
    if (!value.is_number() || is_beyond) fields.refuse("value", "a number of a setting");
    const client::SettingNumber number = value.is_number_integer()
                                             ? client::SettingNumber(value.get<std::int64_t>())
                                             : client::SettingNumber(value.get<double>());
    setting.bits = client::bits_of(setting.type, number);
  } catch (const std::invalid_argument& error) {
    throw trace::InputError(fmt::format("{}: {}", fields.where(), error.what()));
  }
  return setting;
}

client::ModelUpload model_of(const Fields& fields) {
  client::ModelUpload model;
  model.chamber = static_cast<std::uint8_t>(fields.whole("chamber", 1, client::kChambers) - 1);
  const std::string image = fields.text("image");
  for (std::size_t i = 0; i + 1 < image.size(); i += 2) {
    std::uint8_t byte = 0;
    const auto [end, error] = std::from_chars(image.data() + i, image.data() + i + 2, byte, 16);
    if (error != std::errc() || end != image.data() + i + 2) break;
    model.image.push_back(byte);
  }
  if (image.empty() || 2 * model.image.size() != image.size()) {
    fields.refuse("image", "bytes of two hexadecimal digits each");
  }
  return model;
}

Json parse(std::string_view text, const std::string& name) {
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded())
    throw trace::InputError(fmt::format("{}: this is no JSON, expected a JSON file", name));
  return json;
}

}  // namespace

Backup read_backup(client::Session& session) {
  Backup backup;
  backup.node = session.node_id();
  backup.identity = client::read_identity(session);
  backup.versions = client::read_versions(session);
  backup.settings = client::read_settings(session);
  for (std::uint8_t chamber = 0; chamber < client::kChambers; ++chamber) {
    auto image = session.download_model(chamber);
    if (!image.empty()) backup.models.push_back({chamber, std::move(image)});
  }
  return backup;
}

Json backup_json(const Backup& backup) {
  Json settings = Json::array();
  for (const client::Setting& setting : backup.settings) {
    const Json value = std::visit([](auto number) { return Json(number); }, client::number_of(setting));
    settings.push_back({{"index", hex(setting.id.index, 4)},
                        {"sub", setting.id.sub},
                        {"name", setting.name},
                        {"type", client::type_name(setting.type)},
                        {"value", value}});
  }
  Json models = Json::array();
  for (const client::ModelUpload& model : backup.models) {
    models.push_back({{"chamber", model.chamber + 1}, {"image", hex_of(model.image)}});
  }
  return {{"schema", kSchema},
          {"node", backup.node},
          {"identity", identity_json(backup.identity)},
          {"versions", versions_json(backup.versions)},
          {"settings", settings},
          {"models", models}};
}

bool is_backup(const std::filesystem::path& file) {
  const Json json = parse(trace::read_whole_file(file), file.string());
  return json.is_object() && json.value("schema", Json()) == kSchema;
}

Backup load_backup(const std::filesystem::path& file) {
  return parse_backup(trace::read_whole_file(file), file.string());
}

Backup parse_backup(std::string_view text, const std::string& name) {
  const Json json = parse(text, name);
  const Fields fields(json, name);
  if (fields.at("schema") != kSchema) fields.refuse("schema", fmt::format("\"{}\"", kSchema));
  Backup backup;
  backup.node = fields.whole("node", 1, 127);
  const Fields identity(fields.at("identity"), name + ": identity");
  backup.identity = {identity.whole("vendor_id"), identity.whole("product_code"), identity.whole("revision"),
                     identity.whole("serial")};
  const Fields versions(fields.at("versions"), name + ": versions");
  backup.versions = {versions.text("device"),           versions.text("hardware"),
                     versions.text("software"),         versions.hex_number("schema_hash", 0xFFFF'FFFFU),
                     versions.whole("parameter_count"), versions.whole("scalar_format")};
  std::set<client::SettingId> known;
  for (std::size_t i = 0; const Json& one : fields.list("settings")) {
    backup.settings.push_back(setting_of(Fields(one, fmt::format("{}: settings[{}]", name, i++))));
    const client::SettingId id = backup.settings.back().id;
    if (!known.insert(id).second) {
      throw trace::InputError(
          fmt::format("{}: settings: {:04X}h:{} is there twice, expected once", name, id.index, id.sub));
    }
  }
  std::set<unsigned> chambers;
  for (std::size_t i = 0; const Json& one : fields.list("models")) {
    backup.models.push_back(model_of(Fields(one, fmt::format("{}: models[{}]", name, i++))));
    if (!chambers.insert(backup.models.back().chamber).second) {
      throw trace::InputError(fmt::format("{}: models: chamber {} is there twice, expected once", name,
                                          backup.models.back().chamber + 1));
    }
  }
  return backup;
}

}  // namespace plenum::host::tools
