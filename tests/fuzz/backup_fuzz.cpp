// A backup of a board, from any bytes: it is accepted and holds together, or refused with an error of one line that names the file.
#include <cstdint>
#include <set>
#include <string_view>
#include <variant>

#include "host-sim/tools/backup_file.hpp"
#include "host-sim/trace/input_error.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plenum::host;
  using plenum::fuzz::require;
  try {
    const std::string_view text = plenum::fuzz::text_of(data, size);
    const tools::Backup backup = tools::parse_backup(text, "input.json");
    const tools::Json json = tools::Json::parse(text);
    require(backup.node >= 1 && backup.node <= 127, "it is of a node");
    std::set<client::SettingId> ids;
    for (const client::Setting& setting : backup.settings) {
      require(ids.insert(setting.id).second, "a setting is there once");
      // as it crosses the bus and comes back
      require(client::bits_of(setting.type, client::number_of(setting)) == setting.bits,
              "a value fits its type");
    }
    for (std::size_t i = 0; i < backup.settings.size(); ++i) {
      const client::SettingNumber number = client::number_of(backup.settings[i]);
      const auto* whole = std::get_if<std::int64_t>(&number);
      require(whole == nullptr || static_cast<double>(*whole) == json["settings"][i]["value"].get<double>(),
              "a whole number is the one that is written");
    }
    unsigned chambers = 0;
    for (const client::ModelUpload& model : backup.models) {
      require(model.chamber < client::kChambers && (chambers >> model.chamber & 1U) == 0,
              "a chamber has one model at most");
      require(!model.image.empty(), "a model has bytes");
      chambers |= 1U << model.chamber;
    }
    const std::string written = tools::backup_json(backup).dump();
    require(tools::backup_json(tools::parse_backup(written, "written.json")).dump() == written,
            "an accepted backup reads back");
  } catch (const trace::InputError& error) {
    const std::string_view said = error.what();
    require(said.find("input.json") != std::string_view::npos && said.find('\n') == std::string_view::npos,
            "an error of one line names the file that was read");
  }
  return 0;
}
