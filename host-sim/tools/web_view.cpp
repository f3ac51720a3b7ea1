#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "host-sim/tools/monitor_views.hpp"

namespace plenum::host::tools {
namespace {

constexpr std::size_t kLargestRequest = 8192;
constexpr std::size_t kLargestBacklog = std::size_t{8}
                                        << 20U;  ///< of a browser that does not read: it is let go
constexpr std::size_t kMostClients = 16;

std::string response(const char* status, const char* type, const std::string& body) {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n{}",
      status, type, body.size(), body);
}

/// A page of another site must not read a board through its visitor's browser: the name it asks for gives it away.
bool asks_for_loopback(const std::string& request) {
  for (const char* name : {"127.0.0.1", "localhost", "[::1]"}) {
    for (const char* field : {"\r\nHost: ", "\r\nhost: "}) {
      const std::string line = std::string(field) + name;
      const std::size_t found = request.find(line);
      if (found == std::string::npos) continue;
      const char after = request[found + line.size()];  // a request ends in an empty line: there is one
      if (after == ':' || after == '\r') return true;
    }
  }
  return false;
}

}  // namespace

WebView::WebView(const std::string& host, std::uint16_t port, std::string page)
    : host_(host), port_(port), page_(std::move(page)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  if (::inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
    throw std::invalid_argument(
        fmt::format("--web-address {}: expected an IPv4 address of this machine", host));
  }
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  socklen_t size = sizeof address;
  if (::bind(listener_, generic, size) != 0 || ::listen(listener_, kMostClients) != 0) {
    const std::string reason = std::strerror(errno);
    ::close(listener_);
    throw std::runtime_error(
        fmt::format("--web {}: cannot listen on {}: {}, expected a free port", port, host, reason));
  }
  ::getsockname(listener_, generic, &size);
  port_ = ntohs(address.sin_port);
}

WebView::~WebView() {
  for (const Client& client : clients_) ::close(client.socket);
  ::close(listener_);
}

std::string WebView::url() const {
  return fmt::format("http://{}:{}/", host_, port_);
}

void WebView::accept_clients() {
  while (clients_.size() < kMostClients) {
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0) return;
    clients_.push_back({.socket = socket, .request = {}, .waiting = {}});
  }
}

/// False when the client has gone, or asks for too much.
bool WebView::read_from(Client& client) {
  std::array<char, 4096> chunk{};
  while (true) {
    const ssize_t count = ::recv(client.socket, chunk.data(), chunk.size(), 0);
    if (count == 0) return false;
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    if (client.events || client.ending) continue;  // answered already
    client.request.append(chunk.data(), static_cast<std::size_t>(count));
    if (client.request.find("\r\n\r\n") != std::string::npos) {
      answer(client);
    } else if (client.request.size() > kLargestRequest) {
      return false;
    }
  }
}

void WebView::answer(Client& client) {
  const auto asks_for = [&](const char* path) {
    return client.request.rfind(fmt::format("GET {} ", path), 0) == 0;
  };
  client.ending = true;
  if (host_ == "127.0.0.1" && !asks_for_loopback(client.request)) {
    client.waiting = response("403 Forbidden", "text/plain", "this page is for 127.0.0.1 and localhost\n");
  } else if (asks_for("/")) {
    client.waiting = response("200 OK", "text/html", page_);
  } else if (asks_for("/events")) {
    client.waiting =
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\nConnection: "
        "close\r\n\r\n";
    client.events = true;
    client.ending = false;
  } else {
    client.waiting = response("404 Not Found", "text/plain", "there are / and /events\n");
  }
}

/// False when the client is done with, or gone.
bool WebView::write_to(Client& client) {
  while (!client.waiting.empty()) {
    const ssize_t count = ::send(client.socket, client.waiting.data(), client.waiting.size(), MSG_NOSIGNAL);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    client.waiting.erase(0, static_cast<std::size_t>(count));
  }
  return !client.ending;
}

void WebView::serve() {
  accept_clients();
  std::erase_if(clients_, [this](Client& client) {
    if (read_from(client) && write_to(client) && client.waiting.size() <= kLargestBacklog) return false;
    ::close(client.socket);
    return true;
  });
}

void WebView::show(const Json& view) {
  const std::string event = fmt::format("data: {}\n\n", view.dump());
  for (Client& client : clients_) {
    if (client.events) client.waiting += event;
  }
  serve();
}

}  // namespace plenum::host::tools
