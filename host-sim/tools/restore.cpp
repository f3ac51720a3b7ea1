#include <algorithm>
#include <memory>
#include <set>
#include <stdexcept>

#include "host-sim/client/storing.hpp"
#include "host-sim/tools/backup_file.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/stop_signal.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/legible.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  std::string file;
  bool settings_only = false;
  bool partial = false;
  bool no_save = false;
  bool move = false;
  bool force = false;
  Output output;
};

std::string name_of(const client::Setting& setting) {
  return fmt::format("{:04X}h:{} {}", setting.id.index, setting.id.sub, setting.name);
}

void require_fitting(const Backup& backup, client::Session& session, const Options& options) {
  if (backup.node != session.node_id()) {
    throw trace::InputError(
        fmt::format("{}: is of node {}, expected one of node {}: identifiers hold the node id, and --move "
                    "changes it in them",
                    options.file, backup.node, session.node_id()));
  }
  const bool same_schema = backup.versions.schema_hash == client::own_schema_hash() &&
                           backup.versions.parameter_count == client::own_parameter_count();
  if (same_schema || options.settings_only) return;
  throw trace::InputError(
      fmt::format("{}: has models of schema {} with {} parameters, expected {} with {}: --settings-only "
                  "leaves the models alone",
                  options.file, hex(backup.versions.schema_hash, 8), backup.versions.parameter_count,
                  hex(client::own_schema_hash(), 8), client::own_parameter_count()));
}

/// A file that was cut would leave the board half as it was.
void require_complete(const Backup& backup, client::Session& session, const Options& options) {
  std::set<client::SettingId> stated;
  for (const client::Setting& setting : backup.settings) stated.insert(setting.id);
  std::vector<std::string> missing;
  for (const client::Setting& setting : client::read_settings(session)) {
    if (!stated.contains(setting.id)) missing.push_back(name_of(setting));
  }
  if (missing.empty()) return;
  throw trace::InputError(fmt::format(
      "{}: lacks {} that node {} has: {}; expected all of them: --partial leaves these alone", options.file,
      counted(missing.size(), "setting"), session.node_id(), trace::legible_list(missing)));
}

/// Chambers, from 1, that have a model on the board and none in the backup.
std::vector<unsigned> models_beside(const Backup& backup, client::Session& session) {
  std::vector<unsigned> chambers;
  for (std::uint8_t chamber = 0; chamber < client::kChambers; ++chamber) {
    const bool stated = std::any_of(backup.models.begin(), backup.models.end(),
                                    [&](const auto& model) { return model.chamber == chamber; });
    if (!stated && !session.download_model(chamber).empty()) chambers.push_back(chamber + 1U);
  }
  return chambers;
}

/// While settings are written the PDOs are off: what ends that half-way is told with the way back.
std::vector<client::SettingTrouble> write_all(client::Session& session, const Backup& backup) try {
  return client::write_settings(session, backup.settings);
} catch (const std::exception& error) {
  throw std::runtime_error(
      fmt::format("{}; node {} has some of the settings, its PDOs may be off, and nothing is stored: "
                  "plenum reset --restart brings back what it had",
                  error.what(), session.node_id()));
}

int run(const Options& options) {
  Backup backup = load_backup(options.file);
  options.board.require_store();
  BoardAccess access(options.board);
  client::Session& session = access.session();
  const ShownTransfers shown(session, "restoring");
  if (options.move) {
    client::move_settings(backup.settings, static_cast<std::uint8_t>(backup.node), session.node_id());
    backup.node = session.node_id();
  }
  require_fitting(backup, session, options);
  client::require_compatible(session);
  client::require_at_rest(session, "its settings are not changed while it regulates");
  if (!options.partial) require_complete(backup, session, options);
  options.board.keep_rig();
  const StopSignal
      until_whole;  // a first Ctrl-C does not leave a board with its PDOs off, or to a master that is gone
  session.take_to_init();  // who regulated or recorded before left it DISABLED
  std::vector<client::Comparison> comparisons;
  if (!options.settings_only && !backup.models.empty()) {
    comparisons = session.upload_models(backup.models,
                                        options.force ? client::Doubted::accept : client::Doubted::refuse);
    client::await_stored(session);
  }
  const auto troubles = write_all(session, backup);
  const bool stored = !options.no_save && troubles.empty() && client::store_settings(session);
  const auto beside = options.settings_only ? std::vector<unsigned>() : models_beside(backup, session);

  const std::size_t models = options.settings_only ? 0 : backup.models.size();
  options.output.print("node {}: {} of {} and {} written and read back identical\n", session.node_id(),
                       backup.settings.size() - troubles.size(), counted(backup.settings.size(), "setting"),
                       counted(models, "model"));
  Json compared = Json::array();
  for (std::size_t i = 0; i < comparisons.size(); ++i) {
    const unsigned chamber = backup.models[i].chamber + 1U;
    const std::string caveat = client::caveat_of(comparisons[i]);
    if (!caveat.empty()) options.output.print("  chamber {}: {}\n", chamber, caveat);
    compared.push_back({{"chamber", chamber}, {"comparison", comparison_json(comparisons[i])}});
  }
  Json list = Json::array();
  for (const client::SettingTrouble& one : troubles) {
    options.output.print("  not written: {}: {}\n", name_of(one.setting), one.reason);
    list.push_back({{"index", hex(one.setting.id.index, 4)},
                    {"sub", one.setting.id.sub},
                    {"name", one.setting.name},
                    {"reason", one.reason}});
  }
  if (!beside.empty()) {
    options.output.print(
        "  not as in the backup: it has no model of chamber {}, and the board keeps the one it has: a model "
        "can "
        "be replaced, not removed\n",
        fmt::join(beside, ", "));
  }
  options.output.print(
      "{}\n", stored ? "the board has stored its settings (1010h)"
              : !troubles.empty()
                  ? "settings are in force until the next start: not stored, because some are missing"
              : options.no_save
                  ? "settings are in force until the next start: not stored, as asked"
                  : "settings are in force until the next start: this firmware has no 1010h to store them");
  options.output.finish({{"file", options.file},
                         {"node", session.node_id()},
                         {"settings", backup.settings.size() - troubles.size()},
                         {"models", models},
                         {"comparisons", compared},
                         {"not_written", list},
                         {"models_beside", beside},
                         {"stored", stored}});
  return troubles.empty() && beside.empty() ? kDone : kFailure;
}

}  // namespace

Command add_restore(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("restore",
                      "Give a board the settings and models of a backup; read back, and stored on the board; "
                      "exit code 1 when it is not as in the backup then");
  options->board.add_to(arguments);
  arguments.flag("--settings-only", options->settings_only,
                 "Leave the models alone; needed for a backup whose models are of another schema");
  arguments.flag("--partial", options->partial,
                 "Leave alone the settings that the backup lacks, as one of an older firmware may");
  arguments.flag("--move", options->move,
                 "Take over the backup of a board with another node id, whose identifiers become this one's");
  arguments.flag("--no-save", options->no_save,
                 "Do not store: the settings hold until the board's next start");
  arguments.flag(
      "--force", options->force,
      "Take models that the board doubts: its own log says they predict worse, or they are of another valve");
  arguments.option("FILE", options->file, "What plenum backup wrote").type_name("FILE.json").required();
  options->output.add_to(arguments);
  arguments.footer(example("  plenum restore --bus socketcand:127.0.0.1:29536/can0 --node 5 node-5.json"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
