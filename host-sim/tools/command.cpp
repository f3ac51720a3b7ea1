#include "host-sim/tools/command.hpp"

namespace plenum::host::tools {

CLI::App* subcommand(CLI::App& of, const std::string& name, const std::string& about) {
  return of.add_subcommand(name, about);
}

}  // namespace plenum::host::tools
