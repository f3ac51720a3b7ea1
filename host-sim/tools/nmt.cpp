#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <stdexcept>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  bool start = false;
  bool pre_operational = false;
  bool stop = false;
  Output output;
};

struct Order {
  bool asked;
  canopen::NmtCommand command;
  canopen::NmtState state;
};

int run(const Options& options) {
  constexpr double kHeartbeat_s = 2.5;  // one comes each second by default
  const std::array orders{Order{options.start, canopen::NmtCommand::start, canopen::NmtState::operational},
                          Order{options.pre_operational, canopen::NmtCommand::enter_pre_operational,
                                canopen::NmtState::pre_operational},
                          Order{options.stop, canopen::NmtCommand::stop, canopen::NmtState::stopped}};
  const Order* chosen = nullptr;
  for (const Order& one : orders) {
    if (!one.asked) continue;
    if (chosen != nullptr)
      throw std::invalid_argument(
          "several things are said, expected one of --start, --pre-operational, --stop");
    chosen = &one;
  }
  if (chosen == nullptr)
    throw std::invalid_argument("nothing is said, expected one of --start, --pre-operational, --stop");

  BoardAccess access(options.board);
  client::Session& session = access.session();
  session.nmt(chosen->command);
  // heartbeats under way when the order came still tell the state before
  const client::Link& link = access.link();
  const double end_s = link.now_s() + kHeartbeat_s;
  std::optional<canopen::NmtState> state;
  try {
    while (state != chosen->state) state = session.wait_heartbeat(std::max(end_s - link.now_s(), 0.0));
  } catch (const client::Timeout&) {
    if (!state)
      throw client::Timeout(
          fmt::format("node {}: was told, but no heartbeat within {} s says what it is now (1017h)",
                      session.node_id(), kHeartbeat_s));
    throw client::Refused(fmt::format("node {}: is {}, expected {}", session.node_id(),
                                      client::nmt_name(*state), client::nmt_name(chosen->state)));
  }
  options.output.print("node {} is {}\n", session.node_id(), client::nmt_name(*state));
  options.output.finish({{"node", session.node_id()}, {"nmt", client::nmt_name(*state)}});
  return kDone;
}

}  // namespace

Command add_nmt(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command("nmt",
                                        "Start or stop a board's process data (NMT): as it powers up a board "
                                        "is pre-operational, and its PDOs wait. "
                                        "Waits for the heartbeat that says so");
  options->board.add_to(arguments);
  arguments.flag("--start", options->start, "Operational: PDOs, SYNC and set points run");
  arguments.flag("--pre-operational", options->pre_operational,
                 "No PDOs; a board in ACTIVE loses its set points and goes to its safe state, HOLD goes on");
  arguments.flag("--stop", options->stop, "No PDOs and no SDOs: nothing but NMT and the heartbeat");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum nmt --start --bus socketcand:127.0.0.1:29536/can0 --node 5"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
