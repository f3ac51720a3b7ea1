// can_door: the virtual board's second CAN controller, open to the PC outside by the protocol of socketcand.
//
//   can_door INTERFACE PORT
//
// One client at a time, which opens INTERFACE in raw mode: `plenum --bus socketcand:127.0.0.1:PORT/INTERFACE`. A frame that
// the interface's queue has no room for waits, and the client with it, so that none is lost on the way in; a client that does
// not read is disconnected.
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <exception>
#include <optional>
#include <string>
#include <string_view>

#include "board/drivers/socketcan.hpp"
#include "host-sim/wire/file_descriptor.hpp"
#include "host-sim/wire/socketcand.hpp"
#include "host-sim/wire/tcp.hpp"

namespace {

namespace wire = plenum::host::wire;
using plenum::board::drivers::SocketCan;
using plenum::ports::CanFrame;

constexpr int kRetry_ms = 1;  // how soon a frame that found the queue full is offered again

class Client {
 public:
  Client(wire::FileDescriptor socket, SocketCan& can, std::string interface)
      : socket_(std::move(socket)), can_(can), interface_(std::move(interface)) {
    write("< hi >");
  }

  bool gone() const { return gone_; }
  /// A frame of its own waits for room on the bus.
  bool waiting() const { return held_.has_value(); }
  int descriptor() const { return socket_.number(); }

  void read() {
    std::array<char, 4096> bytes{};
    const ssize_t count = ::recv(socket_.number(), bytes.data(), bytes.size(), 0);
    gone_ = gone_ || count <= 0 || !reader_.append({bytes.data(), static_cast<std::size_t>(count)});
  }

  /// Sends what waits, in order, as far as the bus has room.
  void handle() {
    while (!gone_) {
      if (held_ && !can_.send(*held_)) return;
      held_.reset();
      const auto message = reader_.next();
      if (!message) return;
      handle(*message);
    }
  }

  void hand(const CanFrame& frame, std::uint64_t time_us) {
    if (raw_ && !frame.remote) write(wire::frame_message(frame, time_us));
  }

 private:
  void handle(const std::string& message) {
    const auto words = wire::words_of(message);
    if (words.size() == 2 && words[0] == "open" && words[1] == interface_) {
      write("< ok >");
    } else if (words.size() == 1 && words[0] == "rawmode") {
      raw_ = true;
      write("< ok >");
    } else if (words.size() == 1 && words[0] == "echo") {
      write("< echo >");
    } else if (const auto frame = wire::parse_send(words)) {
      held_ = *frame;
    } else {
      write("< error unknown command >");
    }
  }

  void write(std::string_view text) {
    const ssize_t count = ::send(socket_.number(), text.data(), text.size(), MSG_NOSIGNAL);
    gone_ = gone_ || count != static_cast<ssize_t>(text.size());
  }

  wire::FileDescriptor socket_;
  SocketCan& can_;
  std::string interface_;
  wire::MessageReader reader_;
  std::optional<CanFrame> held_;
  bool raw_ = false;
  bool gone_ = false;
};

void serve(const std::string& interface, std::uint16_t port) {
  SocketCan can(interface);
  const wire::FileDescriptor listening = wire::listen_tcp("0.0.0.0", port);
  std::optional<Client> client;
  while (!can.is_down()) {
    const int visitor = client ? client->descriptor() : listening.number();
    const bool full = client && client->waiting();
    std::array<pollfd, 2> ready = {{{can.descriptor(), POLLIN, 0}, {full ? -1 : visitor, POLLIN, 0}}};
    ::poll(ready.data(), ready.size(), full ? kRetry_ms : -1);
    CanFrame frame;
    while (can.receive(frame)) {
      if (client) client->hand(frame, can.received_ns() / 1000);
    }
    if (!client && ready[1].revents != 0) {
      wire::FileDescriptor socket = wire::accept_tcp(listening);
      if (socket) client.emplace(std::move(socket), can, interface);
    } else if (client) {
      if (ready[1].revents != 0) client->read();
      client->handle();
      if (client->gone()) client.reset();
    }
  }
}

}  // namespace

int main(int count, char** words) try {
  std::uint16_t port = 0;
  const char* const end = count == 3 ? words[2] + std::strlen(words[2]) : nullptr;
  if (count != 3 || std::from_chars(words[2], end, port).ptr != end) {
    std::fputs("usage: can_door INTERFACE PORT\n", stderr);
    return 2;
  }
  serve(words[1], port);
  std::fprintf(stderr, "can_door: %s is down\n", words[1]);
  return 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "can_door: %s\n", error.what());
  return 1;
}
