#include "host-sim/client/scan.hpp"

#include <algorithm>
#include <memory>

#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  double seconds = 1.2;  // a heartbeat comes once a second by default
  std::optional<int> bit_rate;
  Output output;
};

std::string identity_text(const client::Identity& identity) {
  return fmt::format("{:X}/{:X}/{:X}/{}", identity.vendor_id, identity.product_code, identity.revision,
                     identity.serial);
}

Json json_of(const client::ScannedNode& node) {
  Json result{{"node", node.node_id}, {"nmt", node.nmt ? Json(client::nmt_name(*node.nmt)) : Json(nullptr)}};
  result["device_type"] = node.device_type ? Json(hex(*node.device_type, 8)) : Json(nullptr);
  result["identity"] = node.device_type ? identity_json(node.identity) : Json(nullptr);
  result["device"] = node.name;
  result["software"] = node.software;
  result["board"] = nullptr;
  if (node.board) {
    result["board"] = {
        {"state", client::state_name(node.board->status_word,
                                     node.board->fault ? node.board->fault->code : std::uint16_t{0})},
        {"models", node.board->models},
        {"compatible", node.board->compatible},
        {"fault", fault_json(node.board->fault)}};
  }
  result["trouble"] = node.trouble.empty() ? Json(nullptr) : Json(node.trouble);
  return result;
}

void print_row(const Output& output, const client::ScannedNode& node) {
  const char* nmt = node.nmt ? client::nmt_name(*node.nmt) : "-";
  if (!node.board) {
    std::string rest = "does not answer SDO";
    if (node.device_type)
      rest = *node.device_type == canopen::kDeviceType ? "cannot be read" : "not a Plenum board";
    if (!node.trouble.empty()) rest += ": " + node.trouble;
    output.print("{:>4}  {:<15}  {:<22}  {:<18}  {:<10}  {}\n", node.node_id, nmt,
                 node.name.empty() ? "-" : node.name, node.device_type ? identity_text(node.identity) : "-",
                 node.software.empty() ? "-" : node.software, rest);
    return;
  }
  const client::BoardSummary& board = *node.board;
  const std::string state =
      client::state_name(board.status_word, board.fault ? board.fault->code : std::uint16_t{0});
  output.print("{:>4}  {:<15}  {:<22}  {:<18}  {:<10}  {:<14}  {:>6}  {}{}\n", node.node_id, nmt, node.name,
               identity_text(node.identity), node.software, state,
               fmt::format("{}/{}", board.models, client::kChambers),
               board.fault ? client::fault_text(*board.fault) : "-",
               board.compatible ? "" : "; models of another release");
}

int run(const Options& options) {
  BoardAccess access(options.board);
  Progress progress("scanning");
  const std::vector<client::ScannedNode> nodes = client::scan(
      access.link(), options.seconds, options.board.session_config(),
      [&](unsigned node) { progress(node == 0 ? std::string("listening") : fmt::format("node {}", node)); },
      options.bit_rate ? std::optional(static_cast<std::uint32_t>(*options.bit_rate)) : std::nullopt);
  Json list = Json::array();
  if (!nodes.empty()) {
    options.output.print("{:>4}  {:<15}  {:<22}  {:<18}  {:<10}  {:<14}  {:>6}  {}\n", "node", "NMT",
                         "device", "vendor/prod/rev/sn", "software", "state", "models", "fault");
  }
  for (const client::ScannedNode& node : nodes) {
    print_row(options.output, node);
    list.push_back(json_of(node));
  }
  if (nodes.empty()) {
    options.output.print(
        "no node answered on {} within {:g} s, expected one of 1..127: is the bit rate right, is it "
        "powered?\n",
        options.board.bus, options.seconds);
  }
  options.output.finish({{"bus", options.board.bus}, {"nodes", list}});
  const bool unread = std::any_of(nodes.begin(), nodes.end(), [](const client::ScannedNode& node) {
    return node.device_type == canopen::kDeviceType && !node.board;
  });
  return nodes.empty() || unread ? kFailure : kDone;
}

}  // namespace

Command add_scan(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command("scan",
                                        "Find the nodes of a bus: identity, state, models, faults. Listens "
                                        "first, and asks the ids of 1..127 that are silent one by one");
  options->board.add_to(arguments);
  arguments
      .option("--seconds", options->seconds,
              "How long to listen, the last 0.4 s of it while asking; a node whose heartbeat is slower shows "
              "no NMT state [s]")
      .within(0.05, 60.0)
      .show_default();
  arguments
      .option("--bit-rate", options->bit_rate,
              "Of the bus: a slow one is asked slowly. Known of can:, slcan: and inproc; to a socketcand "
              "server it "
              "should be said below 125000 [bit/s]")
      .within(10'000, 1'000'000);
  options->output.add_to(arguments);
  arguments.footer(example("  plenum scan --bus socketcand:127.0.0.1:29536/can0"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
