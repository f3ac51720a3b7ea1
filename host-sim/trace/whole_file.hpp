// Files are read whole and written whole: a reader never sees half a file, and neither does the next program.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace plenum::host::trace {

/// The bytes of `path`. Throws InputError if it cannot be opened or read.
std::string read_whole_file(const std::filesystem::path& path);

/// Writes to a temporary neighbour of `path` and renames it into place, with the mode of the file that it replaces. A
/// link stays, what it leads to is replaced; a device, pipe or socket is written to. On failure throws InputError,
/// an old file stands as it was and the temporary is gone.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace plenum::host::trace
