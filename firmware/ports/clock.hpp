// Monotonic time, as the core sees it.
#pragma once

#include <cstdint>

namespace plenum::ports {

class Clock {
 public:
  /// Monotonic time since an arbitrary origin [ns].
  virtual std::uint64_t now_ns() const noexcept = 0;

 protected:
  ~Clock() = default;
};

}  // namespace plenum::ports
