// What whoever started the program has said in its environment.
#pragma once

#include <cstdlib>
#include <string_view>

namespace plenum::board {

/// Empty: it is not there.
inline std::string_view environment(const char* name) noexcept {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string_view{} : value;
}

}  // namespace plenum::board
