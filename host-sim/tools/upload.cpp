#include <memory>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/board_log.hpp"
#include "host-sim/client/storing.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/fleet.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/stop_signal.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/model_json.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  unsigned chamber = 0;
  bool force = false;
  std::vector<std::string> files;
  Output output;
};

unsigned chamber_of(const trace::ModelFile& model, const std::string& file, const Options& options) {
  if (options.chamber != 0 && options.files.size() > 1) {
    throw std::invalid_argument(fmt::format("--chamber {} with {} models, expected one model",
                                            options.chamber, options.files.size()));
  }
  if (options.chamber == 0 && !model.chamber) {
    throw trace::InputError(
        fmt::format("{}: field 'chamber' is missing, expected it there or as --chamber", file));
  }
  const unsigned chamber = options.chamber != 0 ? options.chamber : *model.chamber;
  if (chamber < 1 || chamber > options.board.rig.chambers) {
    throw trace::InputError(fmt::format("{}: chamber {}, expected 1 to {}, those of the board", file, chamber,
                                        options.board.rig.chambers));
  }
  return chamber;
}

int run(const Options& options) {
  options.board.require_store();
  std::vector<client::ModelUpload> uploads;
  Json list = Json::array();
  std::array<std::string, client::kChambers> taken;
  for (const std::string& file : options.files) {
    const trace::ModelFile model = trace::read_model(file);
    const unsigned chamber = chamber_of(model, file, options);
    std::string& by = taken[chamber - 1];
    if (!by.empty()) {
      throw trace::InputError(
          fmt::format("{}: chamber {} has its model from {} already, expected one each", file, chamber, by));
    }
    by = file;
    const double bound_kPa = fixed_error_kPa(model);
    uploads.push_back(upload_of(model, chamber, bound_kPa));
    list.push_back({{"file", file},
                    {"chamber", chamber},
                    {"bytes", uploads.back().image.size()},
                    {"fixed_error_kPa", bound_kPa > 0 ? Json(bound_kPa) : Json(nullptr)}});
  }
  const std::string& store = options.board.store;
  if (options.board.simulated()) require_folder(store);
  BoardAccess board(options.board);
  const StopSignal until_whole;  // a first Ctrl-C does not leave the board to a master that is gone
  const ShownTransfers shown(board.session(), "uploading");
  client::require_compatible(board.session());
  const auto comparisons = board.session().upload_models(
      uploads, options.force ? client::Doubted::accept : client::Doubted::refuse);
  // The session has read back and compared; what is left is that the board keeps them.
  client::await_stored(board.session());
  options.board.keep_rig();
  const bool in_float = client::read_versions(board.session()).in_float();
  for (std::size_t i = 0; i < list.size(); ++i) {
    Json& one = list[i];
    one["comparison"] = comparison_json(comparisons[i]);
    const std::string caveat = client::caveat_of(comparisons[i]);
    const Json& bound_kPa = one["fixed_error_kPa"];
    options.output.print(
        "chamber {}: {}, {} bytes, read back identical{}{}\n", one["chamber"].get<unsigned>(),
        one["file"].get<std::string>(), one["bytes"].get<std::size_t>(),
        !bound_kPa.is_null()
            ? fmt::format("; in fixed point a tick errs by {:.2g} kPa at most", bound_kPa.get<double>())
        : in_float
            ? std::string()
            : std::string("; what it errs by at most in fixed point, as this board computes, is not known"),
        caveat.empty() ? caveat : "; " + caveat);
  }
  const bool frozen = client::log_is_frozen(board.session());
  if (frozen)
    options.output.print(
        "the board's log is frozen: models are compared by what it held then; plenum reset --log lets it go "
        "on\n");
  options.output.finish({{"uploaded", list}, {"log_frozen", frozen}});
  return kDone;
}

}  // namespace

Command add_upload(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("upload", "Hand models to a board over CAN: all or none; read back and compared");
  options->board.add_to(arguments);
  arguments
      .option("--chamber", options->chamber, "Chamber of the board, from 1 (default: the one in the file)")
      .within(1, 8);
  arguments.flag("--force", options->force,
                 "Also models that the board doubts: they predict its log worse than those in force, or are "
                 "of another valve or sensor");
  arguments.option("MODEL", options->files, "Model files").type_name("MODEL.json").required();
  options->output.add_to(arguments);
  arguments.footer(example("  plenum upload --store board model-1.json model-2.json"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
