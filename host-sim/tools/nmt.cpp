#include <memory>

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
  canopen::NmtCommand command;
  canopen::NmtState state;
};

Order order_of(const Options& options) {
  using canopen::NmtCommand, canopen::NmtState;
  if (options.start) return {NmtCommand::start, NmtState::operational};
  if (options.stop) return {NmtCommand::stop, NmtState::stopped};
  return {NmtCommand::enter_pre_operational, NmtState::pre_operational};
}

int run(const Arguments& arguments, const Options& options) {
  constexpr double kHeartbeat_s = 2.5;  // one comes each second by default
  arguments.require_one({"--start", "--pre-operational", "--stop"});
  const auto [command, wanted] = order_of(options);
  BoardAccess access(options.board);
  client::Session& session = access.session();
  session.nmt(command);
  const auto state = session.wait_state(wanted, kHeartbeat_s);
  if (!state)
    throw client::Timeout(
        fmt::format("node {}: was told, but no heartbeat within {} s says what it is now (1017h)",
                    session.node_id(), kHeartbeat_s));
  if (*state != wanted)
    throw client::Refused(fmt::format("node {}: is {}, expected {}", session.node_id(),
                                      client::nmt_name(*state), client::nmt_name(wanted)));
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
  return {arguments, [arguments, options] { return run(arguments, *options); }};
}

}  // namespace plenum::host::tools
