#include "host-sim/client/byte_stream.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace plenum::host::client {
namespace {

bool is_socket(const wire::FileDescriptor& descriptor) {
  struct stat status {};
  return ::fstat(descriptor.number(), &status) == 0 && S_ISSOCK(status.st_mode);
}

}  // namespace

ByteStream::ByteStream(std::string name, wire::FileDescriptor descriptor)
    : name_(std::move(name)), descriptor_(std::move(descriptor)), is_socket_(is_socket(descriptor_)) {}

void ByteStream::fail(const std::string& found) const {
  throw std::runtime_error(fmt::format("{}: {}", name_, found));
}

double ByteStream::now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void ByteStream::write(std::string_view bytes) {
  unsent_ += bytes;
  flush();
  if (unsent_.size() > kUnsentBytes)
    fail(fmt::format("{} bytes wait, expected a peer that takes them", unsent_.size()));
}

std::string ByteStream::read(double until_s) {
  std::array<char, 4096> bytes;
  while (wait(until_s)) {
    flush();
    const ssize_t count = ::read(descriptor_.number(), bytes.data(), bytes.size());
    if (count > 0) return {bytes.data(), static_cast<std::size_t>(count)};
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (count == 0) fail("the peer closed the connection, expected it to stay");
    fail(fmt::format("{}, expected a connection that stands", std::strerror(errno)));
  }
  return {};
}

bool ByteStream::wait(double until_s) {
  while (true) {
    pollfd waiting{descriptor_.number(), static_cast<short>(unsent_.empty() ? POLLIN : POLLIN | POLLOUT), 0};
    const double left_s = std::max(until_s - now_s(), 0.0);
    timespec left{};
    left.tv_sec = static_cast<time_t>(left_s);
    left.tv_nsec = static_cast<long>((left_s - std::floor(left_s)) * 1e9);
    const int ready = ::ppoll(&waiting, 1, &left, nullptr);
    if (ready > 0) return true;
    if (ready == 0) return false;
    if (errno != EINTR) fail(std::strerror(errno));
  }
}

void ByteStream::flush() {
  std::size_t done = 0;
  while (done < unsent_.size()) {
    const char* from = unsent_.data() + done;
    const std::size_t size = unsent_.size() - done;
    const ssize_t count = is_socket_ ? ::send(descriptor_.number(), from, size, MSG_DONTWAIT | MSG_NOSIGNAL)
                                     : ::write(descriptor_.number(), from, size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) break;
    if (count < 0) fail(fmt::format("{}, expected a connection that stands", std::strerror(errno)));
    done += static_cast<std::size_t>(count);
  }
  unsent_.erase(0, done);
}

}  // namespace plenum::host::client
