// One plenumd a CAN interface. The kernel would let a second one write the same outputs, and answer in the first one's name.
#pragma once

#include <chrono>
#include <string>

namespace plenum::board::rt {

/// Holds the name of an interface: an abstract socket, which the kernel gives back with its last holder. The guard is one, by
/// inheritance: nobody follows while it still makes the outputs safe.
class OnlyOne {
 public:
  /// Waits for the one before until `latest`. Throws std::runtime_error.
  OnlyOne(const std::string& interface, std::chrono::steady_clock::time_point latest);
  ~OnlyOne();
  OnlyOne(const OnlyOne&) = delete;
  OnlyOne& operator=(const OnlyOne&) = delete;

 private:
  int socket_ = -1;
};

}  // namespace plenum::board::rt
