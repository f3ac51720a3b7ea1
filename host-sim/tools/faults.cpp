#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

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

Json list_json(const std::vector<client::FaultEntry>& faults) {
  Json list = Json::array();
  for (const client::FaultEntry& fault : faults) list.push_back(fault_json(fault));
  return list;
}

/// A line for each fault and what to do about it; for the same one at several chambers, one after the other, a line for all.
void print(const Output& output, const std::vector<client::FaultEntry>& faults, const char* before) {
  for (auto first = faults.begin(); first != faults.end();) {
    std::string text = client::fault_text(*first);
    auto next = first + 1;
    for (; next != faults.end() && next->code == first->code && next->chamber != 0 && first->chamber != 0;
         ++next)
      text += fmt::format(", {}", next->chamber);
    output.print("{}{}\n  {}\n", before, text, fault_advice(*first));
    first = next;
  }
}

int run(const Options& options) {
  BoardAccess access(options.board);
  client::Session& session = access.session();
  auto standing = client::read_standing_faults(session);
  if (standing.empty()) {  // or the board does not tell
    if (const auto fault = client::read_fault(session)) standing.push_back(*fault);
  }
  const auto history = client::read_fault_history(session);
  print(options.output, standing, "stands now: ");
  if (standing.empty()) options.output.print("no fault stands\n");
  if (std::any_of(standing.begin(), standing.end(), client::reacts)) {
    options.output.print("until a reset the board keeps the 10 s that led to it: plenum capture --last\n");
  }
  options.output.print("{}\n", history.empty() ? "the history is empty" : "history, the newest first:");
  print(options.output, history, "- ");
  if (options.clear_history) {
    client::require_compatible(session);
    session.write<std::uint8_t>(canopen::object::kErrorHistoryIndex, 0, 0);
    options.output.print("the history is cleared\n");
  }
  options.output.finish({{"fault", standing.empty() ? Json(nullptr) : fault_json(standing.front())},
                         {"standing", list_json(standing)},
                         {"history", list_json(history)},
                         {"history_cleared", options.clear_history}});
  return standing.empty() ? kDone : kFailure;
}

}  // namespace

Command add_faults(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "faults",
      "The faults that stand on a board and those before, with what to do; exit code 1 when one stands");
  options->board.add_to(arguments);
  arguments.flag("--clear-history", options->clear_history, "Empty the history (1003h) after showing it");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum faults --bus socketcand:127.0.0.1:29536/can0 --node 5"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
