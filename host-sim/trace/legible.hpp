// What a stranger wrote, as it may be shown.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plenum::host::trace {

/// `text` in printable ASCII, every other byte as \xHH, and "..." behind 60 characters: it stays in one line, and
/// moves no terminal, whatever a file or a node on a bus says.
std::string legible(std::string_view text);

/// The first twenty of `names`, legible and with commas between, and how many more there are.
std::string legible_list(const std::vector<std::string>& names);

}  // namespace plenum::host::trace
