#include <memory>
#include <stdexcept>

#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/fleet.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/model_json.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  std::string out = "models";
  Output output;
};

int run(const Options& options) {
  options.board.require_stored();
  BoardAccess board(options.board);
  const ShownTransfers shown(board.session(), "downloading");
  std::vector<trace::ModelFile> models;
  for (unsigned c = 0; c < options.board.rig.chambers; ++c) {
    const auto image = board.session().download_model(static_cast<std::uint8_t>(c));
    if (!image.empty()) models.push_back(file_of(image, c + 1));
  }
  if (models.empty()) {
    throw std::runtime_error(
        fmt::format("{}: the board has no model, expected at least one", options.board.name()));
  }
  require_folder(options.out);
  Json list = Json::array();
  for (const trace::ModelFile& model : models) {
    const auto file = std::filesystem::path(options.out) / fmt::format("model-{}.json", *model.chamber);
    trace::write_model(file, model);
    options.output.print("chamber {}: {}\n", *model.chamber, file.string());
    list.push_back({{"chamber", *model.chamber}, {"file", file.string()}});
  }
  options.output.finish({{"downloaded", list}});
  return kDone;
}

}  // namespace

Command add_download(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command("download", "Read the models of a board over CAN into model files");
  options->board.add_to(arguments);
  arguments.option("-o,--out", options->out, "Folder for model-N.json").type_name("DIR").show_default();
  options->output.add_to(arguments);
  arguments.footer(example("  plenum download --store board -o models    # models/model-1.json ..."));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
