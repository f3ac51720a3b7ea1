// plenum: one command line for simulation, capture, identification and boards.
#include <fmt/format.h>
#include <plenum_version.hpp>  // written by the build

#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "host-sim/client/session.hpp"
#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/tools/arguments.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/command_line.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/input_error.hpp"

namespace {

using namespace plenum::host;

/// One line on standard error: what, where, what was expected.
int fail(int code, const std::string& command, std::string message) {
  const auto control = [](unsigned char c) { return c < ' ' || c == 0x7F; };
  std::replace_if(message.begin(), message.end(), control, ' ');
  std::fputs(fmt::format("{}: {}\n", command, message).c_str(), stderr);
  return code;
}

int run(const tools::Command& command) {
  const std::string name = fmt::format("plenum {}", command.arguments.name());
  try {
    tools::require_finite_numbers(command.arguments);
    tools::require_files_apart(command.arguments);
    const int code = command.run();
    tools::require_printed();
    return code;
  } catch (const trace::InputError& error) {
    return fail(tools::kBadInput, name, error.what());
  } catch (const std::invalid_argument& error) {
    return fail(tools::kBadInput, name, error.what());
  } catch (const client::Refused& error) {
    return fail(tools::kFailure, name, error.what());
  } catch (const client::SdoAbort& error) {
    return fail(tools::kFailure, name, error.what());
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0)
      return fail(tools::kBadInput, name, "standard output: " + std::string(error.what()));
    return fail(tools::kImpossible, name, error.what());
  }
}

/// That it was printed is all that the command line asked for.
int printed() {
  try {
    tools::require_printed();
  } catch (const trace::InputError& error) {
    return fail(tools::kBadInput, "plenum", error.what());
  }
  return tools::kDone;
}

}  // namespace

int main(int argc, char** argv) {
  tools::hold_closed_streams();
  tools::Program program(
      "plenum",
      "Plenum: simulate valve-controlled pressure chambers, identify them, and regulate them through their "
      "board.",
      kVersion);
  program.footer(
      "Exit codes: 0 done; 1 done, and the answer is a failure; 2 bad usage or input; 3 could not be "
      "computed.\n"
      "\nExample:\n  plenum demo    # the whole line on a simulated rig, and a report of it");
  const std::vector<tools::Command> commands{
      tools::add_demo(program),       tools::add_sim(program),       tools::add_capture(program),
      tools::add_identify(program),   tools::add_diagnose(program),  tools::add_effects(program),
      tools::add_upload(program),     tools::add_download(program),  tools::add_regulate(program),
      tools::add_scan(program),       tools::add_info(program),      tools::add_faults(program),
      tools::add_reset(program),      tools::add_diff(program),      tools::add_backup(program),
      tools::add_restore(program),    tools::add_monitor(program),   tools::add_record(program),
      tools::add_decode(program),     tools::add_blind(program),     tools::add_reproduce(program),
      tools::add_acceptance(program), tools::add_calibrate(program), tools::add_orifice(program),
      tools::add_regulator(program),  tools::add_relief(program),    tools::add_friction(program),
      tools::add_cylinder(program),   tools::add_flow(program),      tools::add_narx(program),
      tools::add_describe(program),   tools::add_lss(program),       tools::add_nmt(program)};

  const auto chosen = [&] {
    return std::find_if(commands.begin(), commands.end(),
                        [](const tools::Command& command) { return command.arguments.given(); });
  };
  try {
    if (!program.parse(argc, argv)) return printed();
  } catch (const trace::InputError& error) {
    return fail(tools::kBadInput, fmt::format("plenum {}", chosen()->arguments.name()), error.what());
  } catch (const std::invalid_argument& error) {
    const auto command = chosen();
    if (command == commands.end() && (argc == 1 || argv[1][0] != '-')) {
      std::vector<std::string> names;
      names.reserve(commands.size());
      for (const tools::Command& one : commands) names.push_back(one.arguments.name());
      return fail(tools::kBadInput, "plenum",
                  fmt::format("{}, expected {}",
                              argc == 1 ? "no command" : fmt::format("'{}' is no command", argv[1]),
                              fmt::join(names, ", ")));
    }
    const std::string name = command == commands.end() ? std::string("plenum")
                                                       : fmt::format("plenum {}", command->arguments.name());
    return fail(tools::kBadInput, name, fmt::format("{} (see {} --help)", error.what(), name));
  }
  return run(*chosen());
}
