#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

#include "host-sim/tools/monitor_views.hpp"

namespace plenum::host::tools {
namespace {

constexpr std::size_t kLargestRequest = 8192;
constexpr std::size_t kLargestBacklog = std::size_t{8}
                                        << 20U;  ///< of a browser that does not read: it is let go
constexpr std::size_t kMostClients = 16;
constexpr double kPatience_s = 10.0;  ///< with one that does not ask, or takes nothing of what is sent

std::string response(const char* status, const char* type, const std::string& body) {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n{}",
      status, type, body.size(), body);
}

/// The lines of a request, each ended by CR LF or by LF alone; none until the empty line behind them is there.
std::vector<std::string_view> lines_of(std::string_view request) {
  std::vector<std::string_view> lines;
  for (std::size_t end = request.find('\n'); end != std::string_view::npos; end = request.find('\n')) {
    std::string_view line = request.substr(0, end);
    request.remove_prefix(end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty()) {
      lines.push_back(line);
    } else if (!lines.empty()) {
      return lines;
    }
  }
  return {};
}

struct RequestLine {
  std::string_view method;
  std::string_view path;  ///< without what is behind a '?'
};

/// Empty when it is none of HTTP/1.
std::optional<RequestLine> request_line(std::string_view line) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == last || !line.substr(last + 1).starts_with("HTTP/1.")) return std::nullopt;
  const std::string_view target = line.substr(first + 1, last - first - 1);
  return RequestLine{line.substr(0, first), target.substr(0, target.find('?'))};
}

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

/// The name that is asked for, in lower case; empty unless the fields are well formed and one of them is Host.
std::optional<std::string> host_of(std::span<const std::string_view> fields) {
  std::optional<std::string> host;
  for (const std::string_view field : fields) {
    const std::size_t colon = field.find(':');
    if (colon == std::string_view::npos || field.find_first_of(" \t") < colon) return std::nullopt;
    if (in_lower_case(field.substr(0, colon)) != "host") continue;
    if (host) return std::nullopt;
    const std::size_t begin = field.find_first_not_of(" \t", colon + 1);
    const std::size_t last = field.find_last_not_of(" \t");
    host = begin == std::string_view::npos ? "" : in_lower_case(field.substr(begin, last + 1 - begin));
  }
  return host;
}

/// A page of another site must not read a board through its visitor's browser: the name it asks for gives it away.
bool is_loopback(std::string_view host) {
  for (const std::string_view name : {"127.0.0.1", "localhost", "[::1]"}) {
    if (!host.starts_with(name)) continue;
    const std::string_view port = host.substr(name.size());
    if (port.empty() || (port[0] == ':' && port.find_first_not_of("0123456789", 1) == std::string_view::npos))
      return true;
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

/// At most so many a time as there are places. Where none is free, the one that has gone longest without asking makes room.
void WebView::accept_clients(double now_s) {
  for (std::size_t i = 0; i < kMostClients; ++i) {
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0) return;
    if (clients_.size() == kMostClients) {
      const auto silent = std::find_if(clients_.begin(), clients_.end(),
                                       [](const Client& client) { return !client.answered; });
      if (silent == clients_.end()) {
        ::close(socket);
        continue;
      }
      ::close(silent->socket);
      clients_.erase(silent);
    }
    clients_.push_back({.socket = socket, .due_s = now_s + kPatience_s, .request = {}, .waiting = {}});
  }
}

/// One chunk: who sends without end holds up nobody else. False when the client has gone, or asks for too much.
bool WebView::read_from(Client& client) {
  std::array<char, 4096> chunk{};
  const ssize_t count = ::recv(client.socket, chunk.data(), chunk.size(), 0);
  if (count == 0) return client.answered;  // it says no more, and may listen still
  if (count < 0) return errno == EAGAIN || errno == EINTR;
  if (client.answered) return true;
  client.request.append(chunk.data(), static_cast<std::size_t>(count));
  const auto lines = lines_of(client.request);
  if (!lines.empty()) answer(client, lines);
  return client.answered || client.request.size() <= kLargestRequest;
}

void WebView::answer(Client& client, std::span<const std::string_view> lines) {
  client.answered = true;
  const auto asked = request_line(lines[0]);
  const auto host = host_of(lines.subspan(1));
  if (!asked || !host) {
    client.waiting =
        response("400 Bad Request", "text/plain", "expected METHOD PATH HTTP/1.1 and one Host\n");
  } else if (host_ == "127.0.0.1" && !is_loopback(*host)) {
    client.waiting = response("403 Forbidden", "text/plain", "this page is for 127.0.0.1 and localhost\n");
  } else if (asked->method != "GET" && asked->method != "HEAD") {
    client.waiting =
        response("405 Method Not Allowed\r\nAllow: GET, HEAD", "text/plain", "expected GET or HEAD\n");
  } else if (asked->path == "/") {
    client.waiting = response("200 OK", "text/html", page_);
  } else if (asked->path == "/events") {
    client.waiting =
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\nConnection: "
        "close\r\n\r\n";
    client.events = asked->method == "GET";
  } else {
    client.waiting = response("404 Not Found", "text/plain", "there are / and /events\n");
  }
  if (asked && asked->method == "HEAD") client.waiting.resize(client.waiting.find("\r\n\r\n") + 4);
}

/// False when the client is done with, or gone.
bool WebView::write_to(Client& client, double now_s) {
  while (!client.waiting.empty()) {
    const ssize_t count = ::send(client.socket, client.waiting.data(), client.waiting.size(), MSG_NOSIGNAL);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    client.waiting.erase(0, static_cast<std::size_t>(count));
    client.due_s = now_s + kPatience_s;
  }
  if (client.events) client.due_s = now_s + kPatience_s;  // it owes nothing until the next view
  return client.events || !client.answered;
}

void WebView::serve(double now_s) {
  accept_clients(now_s);
  std::erase_if(clients_, [this, now_s](Client& client) {
    if (read_from(client) && write_to(client, now_s) && client.waiting.size() <= kLargestBacklog &&
        now_s < client.due_s) {
      return false;
    }
    ::close(client.socket);
    return true;
  });
}

void WebView::show(const Json& view) {
  const std::string event = fmt::format("data: {}\n\n", view.dump());
  for (Client& client : clients_) {
    if (client.events) client.waiting += event;
  }
}

}  // namespace plenum::host::tools
