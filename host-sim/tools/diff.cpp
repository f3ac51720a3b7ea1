#include <algorithm>
#include <memory>

#include "host-sim/client/model_bytes.hpp"
#include "host-sim/tools/backup_file.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/fleet.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  unsigned chamber = 0;
  std::string file;
  Output output;
};

/// One thing in which file and board may differ. Empty text: it is not there.
struct Line {
  std::string what;
  std::string file;
  std::string board;
};

std::string shown(double value) {
  return fmt::format("{}", value);
}

/// Both are decoded from images: what a file's doubles round to is what a board can have.
void compare_models(std::span<const std::uint8_t> file, std::span<const std::uint8_t> board, unsigned chamber,
                    std::vector<Line>& lines) {
  const std::string where = fmt::format("chamber {} ", chamber);
  if (board.empty() || file.empty()) {
    lines.push_back({where + "model", file.empty() ? "" : "there", board.empty() ? "" : "there"});
    return;
  }
  const client::DecodedModel a = client::decode_model(file);
  const client::DecodedModel b = client::decode_model(board);
  lines.push_back({where + "kind", a.kind, b.kind});
  if (a.kind == b.kind) {
    const auto names =
        trace::parameter_names(a.kind).first(std::max(a.parameters.size(), b.parameters.size()));
    const auto stated = [](const client::DecodedModel& model, std::size_t i) {
      return i < model.parameters.size() ? shown(model.parameters[i]) : "";
    };
    for (std::size_t i = 0; i < names.size(); ++i)
      lines.push_back({where + std::string(names[i]), stated(a, i), stated(b, i)});
  }
  lines.push_back({where + "fit error [kPa]", shown(a.origin.fit_error_kPa), shown(b.origin.fit_error_kPa)});
  lines.push_back({where + "fit date [s]", fmt::format("{}", a.origin.fit_date_s),
                   fmt::format("{}", b.origin.fit_date_s)});
  lines.push_back({where + "valve serial", fmt::format("{}", a.origin.valve_serial),
                   fmt::format("{}", b.origin.valve_serial)});
  lines.push_back({where + "sensor serial", fmt::format("{}", a.origin.sensor_serial),
                   fmt::format("{}", b.origin.sensor_serial)});
}

std::string text_of(const client::Setting& setting) {
  return client::text_of(client::number_of(setting));
}

void compare_settings(const std::vector<client::Setting>& file, const std::vector<client::Setting>& board,
                      std::vector<Line>& lines) {
  std::map<client::SettingId, Line> by_id;
  const auto name = [](const client::Setting& s) {
    return fmt::format("{:04X}h:{} {}", s.id.index, s.id.sub, s.name);
  };
  for (const client::Setting& setting : file) by_id[setting.id] = {name(setting), text_of(setting), ""};
  for (const client::Setting& setting : board) {
    Line& line = by_id[setting.id];
    line.what = name(setting);
    line.board = text_of(setting);
  }
  for (const auto& [id, line] : by_id) lines.push_back(line);
}

std::vector<Line> compare_backup(const Options& options, client::Session& session) {
  const Backup file = load_backup(options.file);
  const Backup board = read_backup(session);
  std::vector<Line> lines;
  compare_settings(file.settings, board.settings, lines);
  const auto image_of = [](const Backup& backup, unsigned chamber) -> std::span<const std::uint8_t> {
    for (const client::ModelUpload& model : backup.models) {
      if (model.chamber + 1U == chamber) return model.image;
    }
    return {};
  };
  for (unsigned chamber = 1; chamber <= client::kChambers; ++chamber) {
    const auto in_file = image_of(file, chamber);
    const auto on_board = image_of(board, chamber);
    if (!in_file.empty() || !on_board.empty()) compare_models(in_file, on_board, chamber, lines);
  }
  return lines;
}

std::vector<Line> compare_model(const Options& options, client::Session& session) {
  const trace::ModelFile model = trace::read_model(options.file);
  const unsigned chamber = options.chamber != 0 ? options.chamber : model.chamber.value_or(0);
  if (chamber == 0) {
    throw trace::InputError(
        fmt::format("{}: field 'chamber' is missing, expected it there or as --chamber", options.file));
  }
  if (chamber > client::kChambers) {
    throw trace::InputError(
        fmt::format("{}: chamber {}, expected 1 to {}", options.file, chamber, client::kChambers));
  }
  std::vector<Line> lines;
  constexpr double kNotCompared = 0.0;  // it follows from the parameters
  compare_models(upload_of(model, chamber, kNotCompared).image,
                 session.download_model(static_cast<std::uint8_t>(chamber - 1)), chamber, lines);
  return lines;
}

int run(const Options& options) {
  const bool backup = is_backup(options.file);
  if (backup && options.chamber != 0) {
    throw std::invalid_argument("--chamber with a backup, expected it with a model alone");
  }
  BoardAccess access(options.board);
  const ShownTransfers shown(access.session(), "comparing");
  client::require_compatible(access.session());
  const std::vector<Line> lines =
      backup ? compare_backup(options, access.session()) : compare_model(options, access.session());
  Json list = Json::array();
  std::size_t width = 0;
  for (const Line& line : lines) {
    if (line.file != line.board) width = std::max(width, line.what.size());
  }
  for (const Line& line : lines) {
    if (line.file == line.board) continue;
    if (list.empty()) options.output.print("{:<{}}  {:>20}  {:>20}\n", "differs", width, "file", "board");
    options.output.print("{:<{}}  {:>20}  {:>20}\n", line.what, width, line.file.empty() ? "-" : line.file,
                         line.board.empty() ? "-" : line.board);
    list.push_back({{"what", line.what},
                    {"file", line.file.empty() ? Json(nullptr) : Json(line.file)},
                    {"board", line.board.empty() ? Json(nullptr) : Json(line.board)}});
  }
  options.output.print("{} of {} values differ\n", list.size(), lines.size());
  const bool alike = list.empty();
  options.output.finish(
      {{"file", options.file}, {"alike", alike}, {"compared", lines.size()}, {"differences", list}});
  return alike ? kDone : kFailure;
}

}  // namespace

Command add_diff(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "diff",
      "Compare a model or a backup with what a board has, value by value; exit code 1 when they differ");
  options->board.add_to(arguments);
  arguments
      .option("--chamber", options->chamber, "Chamber of the board, from 1 (default: the one in the model)")
      .within(1, 8);
  arguments.option("FILE", options->file, "A model, or what plenum backup wrote")
      .type_name("FILE.json")
      .required();
  options->output.add_to(arguments);
  arguments.footer(example("  plenum diff --bus socketcand:127.0.0.1:29536/can0 --node 5 model-1.json"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
