// Time as the node is told of it: in steps, of which a late board makes few and long ones.
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/config/limits.hpp"

namespace plenum::canopen {

/// Time accumulates without wrapping.
inline std::uint32_t add_saturating(std::uint32_t a, std::uint32_t b) noexcept {
  return b > UINT32_MAX - a ? UINT32_MAX : a + b;
}

/// How long something that should keep coming has not come.
class Silence {
 public:
  /// It has come.
  void end() noexcept {
    us_ = 0;
    ended_ = true;
  }
  /// Time passes. What waited while the board was late came within the last tick, as far as is known. Returns how long it is silent [us].
  std::uint32_t elapse(std::uint32_t elapsed_us) noexcept {
    us_ = add_saturating(us_, ended_ ? std::min(elapsed_us, config::kTick_us) : elapsed_us);
    ended_ = false;
    return us_;
  }

 private:
  bool ended_ = false;  ///< since time passed last
  std::uint32_t us_ = 0;
};

}  // namespace plenum::canopen
