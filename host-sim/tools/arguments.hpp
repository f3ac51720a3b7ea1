// What is asked of the arguments of every command, whatever their names, once they are parsed and before any work.
#pragma once

namespace plenum::host::tools {

class Arguments;

/// Sees that each number of `command` is finite: a range lets nan through, and many options have none. Throws
/// std::invalid_argument that names the option.
void require_finite_numbers(const Arguments& command);

/// Sees that the value of one option is below that of another. Throws std::invalid_argument that names both.
void require_order(const char* low_option, double low, const char* high_option, double high,
                   const char* unit);

/// Sees that each file to write can be written, and is neither one that is read nor another one to write. What is
/// written is told by the options' names: --json, --out, --report, --save-...; what is no regular file, as /dev/null,
/// may be named twice. Sees likewise that no file of --heldout is another one that is read. Throws trace::InputError.
void require_files_apart(const Arguments& command);

}  // namespace plenum::host::tools
