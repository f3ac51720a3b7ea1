#include <memory>
#include <string>

#include "host-sim/client/board_log.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  bool fault = false;
  bool restart = false;
  bool communication = false;
  bool log = false;
  Output output;
};

constexpr double kBoot_s = 10.0;  ///< a board that starts anew says so within this

/// Clears what has stopped the board, and says what became of it. A fault that has stopped nothing is left alone, and so is the state,
/// which is not this program's to change: somebody may be regulating.
std::string reset_fault(client::Session& session, Json& result) {
  client::require_compatible(session);
  const auto before = client::read_fault(session);
  result["fault_before"] = fault_json(before);
  const bool stopped = before && (session.status_word() & canopen::word::kReady) == 0;
  if (stopped) {
    try {
      session.reset_fault();
    } catch (const client::Refused&) {
      const auto left = client::read_fault(session).value_or(*before);
      throw client::Refused(fmt::format("node {}: fault {} still stands, expected its cause to be gone; {}",
                                        session.node_id(), client::fault_text(left), fault_advice(left)));
    }
  }
  const auto left = stopped ? client::read_fault(session) : before;
  result["fault_left"] = fault_json(left);
  if (!before) return "no fault stands: nothing to reset";
  const std::string stays = left ? fmt::format("{} stands, stops nothing and goes once its cause has gone",
                                               client::fault_text(*left))
                                 : std::string();
  if (!stopped) return "nothing to reset: " + stays;
  return fmt::format("{} is cleared; the board is DISABLED{}{}", client::fault_text(*before),
                     left ? "; " : "", stays);
}

int run(const Arguments& arguments, const Options& options) {
  arguments.require_one({"--fault", "--restart", "--communication", "--log"}, " to be reset");
  BoardAccess access(options.board);
  client::Session& session = access.session();
  Json result{{"node", session.node_id()}};
  if (options.fault) {
    options.output.print("{}\n", reset_fault(session, result));
  } else if (options.log) {
    client::require_compatible(session);
    const bool frozen = client::log_is_frozen(session);
    if (frozen) client::let_log_roll(session);
    options.output.print("{}\n",
                         frozen ? "the log goes on; what it held stays until newer rows have taken its place"
                                : "the log is not frozen: nothing to reset");
  } else {
    session.nmt(options.restart ? canopen::NmtCommand::reset_node : canopen::NmtCommand::reset_communication);
    session.wait_boot_up(kBoot_s);
    options.output.print("node {} has started anew\n", session.node_id());
  }
  result["reset"] = options.fault     ? "fault"
                    : options.log     ? "log"
                    : options.restart ? "node"
                                      : "communication";
  options.output.finish(result);
  return kDone;
}

}  // namespace

Command add_reset(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "reset", "Clear a board's fault, start the board or its communication anew, or let its log go on");
  options->board.add_to(arguments);
  arguments.flag("--fault", options->fault,
                 "Clear the standing fault once its cause is gone; the board is DISABLED then");
  arguments.flag("--restart", options->restart,
                 "NMT reset node: outputs go to their safe state, the board starts anew; a fault stays until "
                 "it is reset");
  arguments.flag(
      "--communication", options->communication,
      "NMT reset communication: identifiers and PDOs as stored; HOLD goes on, ACTIVE ends when its set "
      "points are missed");
  arguments.flag("--log", options->log, "Let a log go on that somebody froze");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum reset --fault --bus socketcand:127.0.0.1:29536/can0 --node 5"));
  return {arguments, [arguments, options] { return run(arguments, *options); }};
}

}  // namespace plenum::host::tools
