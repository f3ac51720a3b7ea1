// What is told on the standard error.
#pragma once

#include <unistd.h>

#include <string_view>

namespace plenum::board {

/// Text for the terminal, or for the journal. That nobody can read it is no reason to leave a valve as it is: it fails silently,
/// where fmt::print would throw.
inline void say(std::string_view text) noexcept {
  (void)!::write(STDERR_FILENO, text.data(), text.size());
}

}  // namespace plenum::board
