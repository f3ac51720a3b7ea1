#include <memory>

#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  bool clear_history = false;
  Output output;
};

int run(const Options& options) {
  BoardAccess access(options.board);
  client::Session& session = access.session();
  const auto fault = client::read_fault(session);
  const auto history = client::read_fault_history(session);
  if (fault) {
    options.output.print("stands now: {}\n  {}\n", client::fault_text(*fault), fault_advice(*fault));
    if (client::reacts(*fault)) {
      options.output.print(
          "  until its reset the board keeps the 10 s that led to it: plenum capture --last\n");
    }
  } else {
    options.output.print("no fault stands\n");
  }
  options.output.print("{}\n", history.empty() ? "the history is empty" : "history, the newest first:");
  Json list = Json::array();
  for (const client::FaultEntry& entry : history) {
    options.output.print("  {}\n    {}\n", client::fault_text(entry), fault_advice(entry));
    list.push_back(fault_json(entry));
  }
  if (options.clear_history) {
    client::require_compatible(session);
    session.write<std::uint8_t>(canopen::object::kErrorHistoryIndex, 0, 0);
    options.output.print("the history is cleared\n");
  }
  options.output.finish(
      {{"fault", fault_json(fault)}, {"history", list}, {"history_cleared", options.clear_history}});
  return fault ? kFailure : kDone;
}

}  // namespace

Command add_faults(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "faults",
      "The fault that stands on a board and those before it, with what to do; exit code 1 when one stands");
  options->board.add_to(arguments);
  arguments.flag("--clear-history", options->clear_history, "Empty the history (1003h) after showing it");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum faults --bus socketcand:127.0.0.1:29536/can0 --node 5"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
