// What the tests of the links share: frames by their bytes, and the words of a failure.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host-sim/client/link.hpp"

namespace plenum::host::client {

/// `bytes`: up to eight.
inline CanFrame frame_of(std::uint32_t id, const std::vector<std::uint8_t>& bytes) {
  CanFrame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size())};
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

/// What the runtime error says that `doing` throws.
inline std::string failure(const std::function<void()>& doing) {
  try {
    doing();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no failure";
}

}  // namespace plenum::host::client
