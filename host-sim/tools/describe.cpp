#include <chrono>
#include <filesystem>
#include <memory>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/lss_master.hpp"
#include "host-sim/client/settings.hpp"
#include "host-sim/dictionary/dbc.hpp"
#include "host-sim/dictionary/device_configuration.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::tools {
namespace {

constexpr std::uint16_t kStoredSheet = 0x1021;
constexpr std::uint16_t kStoredFormat = 0x1022;

struct Options {
  BoardChoice board;
  std::string out = "description";
  unsigned bit_rate = 1'000'000;
  Output output;
};

/// Object 1021h, as plain text.
std::string read_data_sheet(client::Session& session) {
  constexpr std::uint8_t kPlainText = 0;
  const auto format = session.read<std::uint8_t>(kStoredFormat, 0);
  if (format != kPlainText) {
    throw client::ProtocolError(fmt::format("node {}: 1022h is {}, expected 0, a data sheet as plain text",
                                            session.node_id(), format));
  }
  const std::vector<std::uint8_t> bytes = session.sdo_read_domain(kStoredSheet, 0);
  return {bytes.begin(), bytes.end()};
}

dictionary::ObjectValues read_values(client::Session& session) {
  dictionary::ObjectValues values;
  for (const client::Setting& setting : client::read_settings(session))
    values[{setting.id.index, setting.id.sub}] = setting.bits;
  return values;
}

int run(const Options& options) {
  client::bit_timing_row(options.bit_rate);
  BoardAccess access(options.board);
  client::Session& session = access.session();
  const ShownTransfers shown(session, "reading");
  client::require_compatible(session);
  const std::string stem = fmt::format("node-{}", session.node_id());
  const std::string sheet = read_data_sheet(session);
  const dictionary::ObjectValues values = read_values(session);
  const dictionary::Commissioning commissioning{
      .node_id = session.node_id(),
      .bit_rate_per_s = options.bit_rate,
      .node_name = client::read_versions(session).device,
      .serial = client::read_identity(session).serial,
      .data_sheet = stem + ".eds",
      .file_name = stem + ".dcf",
      .created = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now())};

  const std::filesystem::path folder = options.out;
  const OutputFolder made(folder);
  Json files = Json::object();
  const auto write = [&](const char* kind, const char* what, const std::string& text) {
    const auto file = folder / fmt::format("{}.{}", stem, kind);
    trace::write_whole_file(file, text);
    options.output.print("{}: {}\n", file.string(), what);
    files[kind] = file.string();
  };
  write("eds", "electronic data sheet, as the board keeps it at 1021h", sheet);
  write("dcf", "the same for this node, with what it is set to",
        dictionary::device_configuration(sheet, commissioning, values));
  write("dbc", "its PDOs, as they are mapped now", dictionary::dbc(session.node_id(), values));
  options.output.finish({{"node", session.node_id()}, {"files", files}});
  return kDone;
}

}  // namespace

Command add_describe(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "describe",
      "Write what other CANopen tools need to know of a board: EDS, DCF, and DBC for bus monitors");
  options->board.add_to(arguments);
  arguments.option("-o,--out", options->out, "Folder for node-N.eds, node-N.dcf and node-N.dbc")
      .type_name("DIR")
      .show_default();
  arguments.option("--bit-rate", options->bit_rate, "Of the bus, for the DCF [bit/s]").show_default();
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum describe --bus socketcand:127.0.0.1:29536/can0 --node 5    # description/node-5.eds ..."));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
