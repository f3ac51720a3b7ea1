#include "host-sim/client/socketcand_link.hpp"

#include <fmt/format.h>

#include "host-sim/wire/tcp.hpp"
#include "host-sim/wire/time_stamp.hpp"

namespace plenum::host::client {

SocketcandLink::SocketcandLink(const SocketcandAddress& address, double timeout_s)
    : stream_(format_bus(address), wire::connect_tcp(address.host, address.port, timeout_s)) {
  const double until_s = now_s() + timeout_s;
  expect("hi", "connecting", until_s);
  const std::string open = fmt::format("< open {} >", address.channel);
  for (const std::string& question : {open, std::string("< rawmode >")}) {
    stream_.write(question);
    expect("ok", question, until_s);
  }
}

void SocketcandLink::expect(const char* word, const std::string& after, double until_s) {
  const std::optional<std::string> message = next_message(until_s);
  const std::string expected = fmt::format("< {} >", word);
  if (!message)
    stream_.fail(fmt::format("no answer after {}, expected {} of a socketcand server", after, expected));
  if (*message != expected) stream_.fail(fmt::format("{} after {}, expected {}", *message, after, expected));
}

void SocketcandLink::send(const CanFrame& frame) {
  if (frame.remote)
    stream_.fail(
        fmt::format("remote frame {:03X}h, expected a data frame: socketcand has no other", frame.id));
  stream_.write(wire::send_message(frame));
}

std::optional<CanFrame> SocketcandLink::receive(double timeout_s) {
  const double until_s = now_s() + timeout_s;
  while (const std::optional<std::string> message = next_message(until_s)) {
    const auto words = wire::words_of(*message);
    if (const std::optional<CanFrame> frame = wire::parse_frame(words)) {
      stamp_us_ = wire::parse_stamp_us(words[2]);
      return frame;
    }
    // An error frame carries its class in hex and a time; anything else is what the server did not like.
    const bool is_error = !words.empty() && words.front() == "error";
    const bool is_error_frame =
        words.size() >= 3 && words[1].find_first_not_of("0123456789ABCDEFabcdef") == std::string_view::npos;
    if (is_error && !is_error_frame)
      stream_.fail(fmt::format("the server says {}, expected frames", *message));
  }
  return std::nullopt;
}

/// The next message; waits for one until `until_s`, and looks at least once at what is there.
std::optional<std::string> SocketcandLink::next_message(double until_s) {
  while (true) {
    if (auto message = reader_.next()) return message;
    const std::string bytes = stream_.read(until_s);
    if (bytes.empty()) return std::nullopt;
    if (!reader_.append(bytes)) {
      stream_.fail(fmt::format("{} bytes without a message, expected a socketcand server",
                               wire::MessageReader::kLongest));
    }
  }
}

}  // namespace plenum::host::client
