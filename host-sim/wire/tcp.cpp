#include "host-sim/wire/tcp.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace plenum::host::wire {
namespace {

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Addresses resolve(const std::string& host, std::uint16_t port, int flags) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found);
  if (error != 0) {
    throw std::runtime_error(
        fmt::format("{}: {}, expected the name or address of a host", host, ::gai_strerror(error)));
  }
  return {found, &::freeaddrinfo};
}

FileDescriptor socket_for(const addrinfo& address) {
  return FileDescriptor(
      ::socket(address.ai_family, address.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, address.ai_protocol));
}

void set(const FileDescriptor& socket, int level, int option) {
  const int on = 1;
  ::setsockopt(socket.number(), level, option, &on, sizeof on);
}

/// The error that a connection ended in; 0 when it stands.
int await_connection(const FileDescriptor& socket, double timeout_s) {
  pollfd waiting{socket.number(), POLLOUT, 0};
  int ready = 0;
  do {
    ready = ::poll(&waiting, 1, static_cast<int>(std::lround(timeout_s * 1e3)));
  } while (ready < 0 && errno == EINTR);
  if (ready == 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(socket.number(), SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

}  // namespace

FileDescriptor connect_tcp(const std::string& host, std::uint16_t port, double timeout_s) {
  const Addresses addresses = resolve(host, port, 0);
  int error = EADDRNOTAVAIL;
  for (const addrinfo* address = addresses.get(); address != nullptr; address = address->ai_next) {
    FileDescriptor socket = socket_for(*address);
    if (!socket) {
      error = errno;
      continue;
    }
    error = ::connect(socket.number(), address->ai_addr, address->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) error = await_connection(socket, timeout_s);
    if (error != 0) continue;
    set(socket, IPPROTO_TCP, TCP_NODELAY);
    return socket;
  }
  throw std::runtime_error(
      fmt::format("{}:{}: {}, expected a server that listens there", host, port, std::strerror(error)));
}

FileDescriptor listen_tcp(const std::string& host, std::uint16_t port) {
  const Addresses addresses = resolve(host, port, AI_PASSIVE);
  int error = EADDRNOTAVAIL;
  for (const addrinfo* address = addresses.get(); address != nullptr; address = address->ai_next) {
    FileDescriptor socket = socket_for(*address);
    if (socket) {
      set(socket, SOL_SOCKET, SO_REUSEADDR);
      if (::bind(socket.number(), address->ai_addr, address->ai_addrlen) == 0 &&
          ::listen(socket.number(), SOMAXCONN) == 0) {
        return socket;
      }
    }
    error = errno;
  }
  throw std::runtime_error(
      fmt::format("{}:{}: {}, expected a free port of this machine", host, port, std::strerror(error)));
}

std::uint16_t port_of(const FileDescriptor& listening) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  ::getsockname(listening.number(), reinterpret_cast<sockaddr*>(&address), &size);
  if (address.ss_family == AF_INET6) return ntohs(reinterpret_cast<sockaddr_in6*>(&address)->sin6_port);
  return ntohs(reinterpret_cast<sockaddr_in*>(&address)->sin_port);
}

FileDescriptor accept_tcp(const FileDescriptor& listening) {
  FileDescriptor socket(::accept4(listening.number(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (socket) set(socket, IPPROTO_TCP, TCP_NODELAY);
  return socket;
}

}  // namespace plenum::host::wire
