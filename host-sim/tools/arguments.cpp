#include "host-sim/tools/arguments.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace plenum::host::tools {
namespace {

/// The options of `command` and of its subcommands that were named.
std::vector<const CLI::Option*> options_of(const CLI::App& command) {
  std::vector<const CLI::Option*> options = command.get_options();
  for (const CLI::App* of : command.get_subcommands()) {
    const std::vector<const CLI::Option*> more = options_of(*of);
    options.insert(options.end(), more.begin(), more.end());
  }
  return options;
}

}  // namespace

void require_finite_numbers(const CLI::App& command) {
  for (const CLI::Option* const option : options_of(command)) {
    if (option->count() == 0 || !option->get_type_name().starts_with("FLOAT")) continue;
    if (!std::isfinite(option->as<double>())) {
      throw std::invalid_argument(
          fmt::format("{}: {}, expected a finite number", option->get_name(), option->results().front()));
    }
  }
}

}  // namespace plenum::host::tools
