#include <memory>

#include "host-sim/client/borrowed_stream.hpp"
#include "host-sim/tools/backup_file.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  std::string out = "backup.json";
  bool force = false;
  Output output;
};

int run(const Options& options) {
  options.board.require_store();
  BoardAccess access(options.board);
  const ShownTransfers shown(access.session(), "reading");
  client::require_compatible(access.session());
  if (!options.force) {
    client::require_at_rest(access.session(),
                            "what it is given while it regulates would be kept for its settings");
    client::require_no_stream(access.session());
  }
  const Backup backup = read_backup(access.session());
  trace::write_whole_file(options.out, backup_json(backup).dump(2) + '\n');
  options.output.print("node {}: {}, {}: {}\n", backup.node, counted(backup.settings.size(), "setting"),
                       counted(backup.models.size(), "model"), options.out);
  options.output.finish({{"file", options.out},
                         {"node", backup.node},
                         {"settings", backup.settings.size()},
                         {"models", backup.models.size()}});
  return kDone;
}

}  // namespace

Command add_backup(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command("backup", "Save a whole board, its settings and models, to one file");
  options->board.add_to(arguments);
  arguments.option("-o,--out", options->out, "The file").type_name("FILE.json").show_default();
  arguments.flag("--force", options->force,
                 "Also of a board that regulates or streams, with what it has been given for that");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum backup --bus socketcand:127.0.0.1:29536/can0 --node 5 -o node-5.json"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
