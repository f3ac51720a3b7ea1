// What a file holds, as an error may show it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plenum::host::trace {

/// `text` in printable ASCII, every other byte as \xHH, and "..." behind 60 characters: an error stays one line, and
/// moves no terminal, whatever a file holds.
std::string legible(std::string_view text);

/// The first twenty of `names`, legible and with commas between, and how many more there are.
std::string legible_list(const std::vector<std::string>& names);

}  // namespace plenum::host::trace
