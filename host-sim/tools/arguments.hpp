// What is asked of the arguments of every command, whatever their names, once they are parsed and before any work.
#pragma once

namespace CLI {
class App;
}

namespace plenum::host::tools {

/// Sees that each number of `command` is finite: CLI::Range lets nan through, and many options have no range. Throws
/// std::invalid_argument that names the option.
void require_finite_numbers(const CLI::App& command);

/// Sees that each file to write can be written, and is neither one that is read nor another one to write. What is
/// written is told by the options' names: --json, --out, --report, --save-...; what is no regular file, as /dev/null,
/// may be named twice. Throws trace::InputError.
void require_files_apart(const CLI::App& command);

}  // namespace plenum::host::tools
