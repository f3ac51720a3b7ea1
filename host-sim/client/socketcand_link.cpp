#include "host-sim/client/socketcand_link.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "host-sim/wire/tcp.hpp"

namespace plenum::host::client {

SocketcandLink::SocketcandLink(const SocketcandAddress& address, double timeout_s)
    : name_(format_bus(address)), socket_(wire::connect_tcp(address.host, address.port, timeout_s)) {
  const double until_s = now_s() + timeout_s;
  expect("hi", "connecting", until_s);
  unsent_ = fmt::format("< open {} >", address.channel);
  expect("ok", "< open " + address.channel + " >", until_s);
  unsent_ = "< rawmode >";
  expect("ok", "< rawmode >", until_s);
}

void SocketcandLink::fail(const std::string& found) const {
  throw std::runtime_error(fmt::format("{}: {}", name_, found));
}

double SocketcandLink::now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void SocketcandLink::expect(const char* word, const std::string& after, double until_s) {
  const std::optional<std::string> message = next_message(until_s);
  const std::string expected = fmt::format("< {} >", word);
  if (!message) fail(fmt::format("no answer after {}, expected {} of a socketcand server", after, expected));
  if (*message != expected) fail(fmt::format("{} after {}, expected {}", *message, after, expected));
}

void SocketcandLink::send(const CanFrame& frame) {
  if (frame.remote)
    fail(fmt::format("remote frame {:03X}h, expected a data frame: socketcand has no other", frame.id));
  unsent_ += wire::send_message(frame);
  flush();
  if (unsent_.size() > kUnsentBytes)
    fail(fmt::format("{} bytes wait, expected a server that takes them", unsent_.size()));
}

std::optional<CanFrame> SocketcandLink::receive(double timeout_s) {
  const double until_s = now_s() + timeout_s;
  while (const std::optional<std::string> message = next_message(until_s)) {
    const auto words = wire::words_of(*message);
    if (const std::optional<CanFrame> frame = wire::parse_frame(words)) return frame;
    // An error frame carries its class in hex and a time; anything else is what the server did not like.
    const bool is_error = !words.empty() && words.front() == "error";
    const bool is_error_frame =
        words.size() >= 3 && words[1].find_first_not_of("0123456789ABCDEFabcdef") == std::string_view::npos;
    if (is_error && !is_error_frame) fail(fmt::format("the server says {}, expected frames", *message));
  }
  return std::nullopt;
}

/// The next message; waits for one until `until_s`, and looks at least once at what is there.
std::optional<std::string> SocketcandLink::next_message(double until_s) {
  while (true) {
    if (auto message = reader_.next()) return message;
    if (closed_) fail("the server closed the connection, expected it to stay");
    if (!wait(until_s)) return std::nullopt;
    flush();
    take_bytes();
  }
}

bool SocketcandLink::wait(double until_s) {
  while (true) {
    pollfd waiting{socket_.number(), static_cast<short>(unsent_.empty() ? POLLIN : POLLIN | POLLOUT), 0};
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

void SocketcandLink::take_bytes() {
  std::array<char, 4096> bytes;
  const ssize_t count = ::recv(socket_.number(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count < 0) fail(fmt::format("{}, expected a connection that stands", std::strerror(errno)));
  closed_ = count == 0;
  if (!reader_.append({bytes.data(), static_cast<std::size_t>(count)})) {
    fail(fmt::format("{} bytes without a message, expected a socketcand server",
                     wire::MessageReader::kLongest));
  }
}

void SocketcandLink::flush() {
  while (!unsent_.empty()) {
    const ssize_t count =
        ::send(socket_.number(), unsent_.data(), unsent_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return;
    if (count < 0) fail(fmt::format("{}, expected a connection that stands", std::strerror(errno)));
    unsent_.erase(0, static_cast<std::size_t>(count));
  }
}

}  // namespace plenum::host::client
