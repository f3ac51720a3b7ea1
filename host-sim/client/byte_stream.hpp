// Bytes to and from a peer, a socket or a terminal, without a thread: they move while the caller writes or waits.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "host-sim/wire/file_descriptor.hpp"

namespace plenum::host::client {

class ByteStream {
 public:
  /// `name` begins each error. The descriptor must not block.
  ByteStream(std::string name, wire::FileDescriptor descriptor);

  /// Queues bytes. Throws std::runtime_error when the peer is gone, and when it has taken nothing for so long that
  /// kUnsentBytes wait.
  void write(std::string_view bytes);
  /// What has come; waits for it until `until_s`, and looks at least once. Empty when nothing came. Throws
  /// std::runtime_error when the peer is gone.
  std::string read(double until_s);
  /// Seconds since the stream was made, on the monotonic clock.
  double now_s() const;
  [[noreturn]] void fail(const std::string& found) const;

  static constexpr std::size_t kUnsentBytes = 65536;

 private:
  bool wait(double until_s);
  void flush();

  std::string name_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  wire::FileDescriptor descriptor_;
  bool is_socket_;
  std::string unsent_;
};

}  // namespace plenum::host::client
