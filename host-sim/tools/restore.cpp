#include <memory>

#include "host-sim/client/storing.hpp"
#include "host-sim/tools/backup_file.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  std::string file;
  bool settings_only = false;
  bool no_save = false;
  bool force = false;
  Output output;
};

void require_fitting(const Backup& backup, client::Session& session, const Options& options) {
  if (backup.node != session.node_id()) {
    throw trace::InputError(
        fmt::format("{}: is of node {}, expected one of node {}: identifiers of PDOs hold the node id",
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

void require_at_rest(client::Session& session) {
  const std::uint16_t status = session.status_word();
  if (!client::is_regulating(status)) return;
  const auto fault = client::read_fault(session);
  throw client::Refused(fmt::format(
      "node {}: is in {}, expected a board at rest: its settings are not changed while it regulates",
      session.node_id(), client::state_name(status, fault ? fault->code : std::uint16_t{0})));
}

int run(const Options& options) {
  const Backup backup = load_backup(options.file);
  BoardAccess access(options.board);
  client::Session& session = access.session();
  require_fitting(backup, session, options);
  client::require_compatible(session);
  require_at_rest(session);
  if (!options.settings_only && !backup.models.empty()) {
    session.upload_models(backup.models, options.force ? client::Doubted::force : client::Doubted::refuse);
    client::await_stored(session);
  }
  const auto troubles = client::write_settings(session, backup.settings);
  const bool stored = !options.no_save && troubles.empty() && client::store_settings(session);

  const std::size_t models = options.settings_only ? 0 : backup.models.size();
  options.output.print("node {}: {} of {} settings and {} models written and read back alike\n",
                       session.node_id(), backup.settings.size() - troubles.size(), backup.settings.size(),
                       models);
  Json list = Json::array();
  for (const client::SettingTrouble& one : troubles) {
    options.output.print("  not written: {:04X}h:{} {}: {}\n", one.setting.id.index, one.setting.id.sub,
                         one.setting.name, one.reason);
    list.push_back({{"index", hex(one.setting.id.index, 4)},
                    {"sub", one.setting.id.sub},
                    {"name", one.setting.name},
                    {"reason", one.reason}});
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
                         {"not_written", list},
                         {"stored", stored}});
  return troubles.empty() ? kDone : kFailure;
}

}  // namespace

Command add_restore(CLI::App& program) {
  const auto options = std::make_shared<Options>();
  CLI::App* app =
      subcommand(program, "restore",
                 "Give a board the settings and models of a backup; read back, and stored on the board");
  options->board.add_to(*app);
  app->add_flag("--settings-only", options->settings_only,
                "Leave the models alone; needed for a backup whose models are of another schema");
  app->add_flag("--no-save", options->no_save,
                "Do not store: the settings hold until the board's next start");
  app->add_flag(
      "--force", options->force,
      "Take models that the board doubts: its own log says they predict worse, or they are of another valve");
  app->add_option("FILE", options->file, "What plenum backup wrote")->type_name("FILE.json")->required();
  options->output.add_to(*app);
  app->footer(example("  plenum restore --bus socketcand:127.0.0.1:29536/can0 --node 5 node-5.json"));
  return {app, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
