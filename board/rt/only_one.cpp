#include "board/rt/only_one.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace plenum::board::rt {
namespace {

constexpr std::chrono::milliseconds kPause{50};

bool take(int socket, const std::string& interface) noexcept {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = "plenumd/" + interface;  // behind a zero: in no folder
  const std::size_t length = name.copy(address.sun_path + 1, sizeof address.sun_path - 1);
  return ::bind(socket, reinterpret_cast<const sockaddr*>(&address),
                static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length)) == 0;
}

}  // namespace

OnlyOne::OnlyOne(const std::string& interface, std::chrono::steady_clock::time_point latest)
    : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  while (!take(socket_, interface)) {
    const int error = errno;
    if (error == EADDRINUSE && std::chrono::steady_clock::now() < latest) {
      std::this_thread::sleep_for(kPause);
      continue;
    }
    if (socket_ >= 0) ::close(socket_);
    throw std::runtime_error(interface + ": " +
                             (error == EADDRINUSE ? "another plenumd runs on it" : std::strerror(error)) +
                             ", expected to be the only one");
  }
}

OnlyOne::~OnlyOne() {
  ::close(socket_);
}

}  // namespace plenum::board::rt
