#include "host-sim/client/slcan_link.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <termios.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <stdexcept>

#include "host-sim/wire/slcan.hpp"

namespace plenum::host::client {
namespace {

constexpr std::string_view kOpen = "O";
constexpr double kAnswer_s = 0.1;  ///< that an adapter is given to answer a command
constexpr double kTaken_s = 0.5;   ///< likewise a frame
constexpr double kRest_s = 0.02;   ///< what is begun or under way when the link opens is over then
constexpr double kRefused_s =
    1.0;  ///< a frame is offered again so long: the bus is blocked, or others take all of it
constexpr double kPause_s = 0.002;      ///< between two offers, some frames at 1 Mbit/s
constexpr std::size_t kAhead = 8;       ///< frames that may wait for an answer: adapters have room for more
constexpr std::size_t kLongest = 1024;  ///< bytes without a line's end that are no slcan

wire::FileDescriptor open_terminal(const SlcanAddress& address) {
  const auto refuse = [&](const char* found) {
    throw std::runtime_error(
        fmt::format("{}: {}, expected the terminal of a serial CAN adapter", format_bus(address), found));
  };
  wire::FileDescriptor terminal(::open(address.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!terminal) refuse(std::strerror(errno));
  termios settings{};
  if (::tcgetattr(terminal.number(), &settings) != 0) refuse("is no terminal");
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  ::cfsetspeed(&settings, B115200);
  if (::tcsetattr(terminal.number(), TCSANOW, &settings) != 0) refuse(std::strerror(errno));
  return terminal;
}

}  // namespace

SlcanLink::SlcanLink(const SlcanAddress& address)
    : stream_(format_bus(address), open_terminal(address)), bit_rate_(address.bit_rate) {
  stream_.write("\r\r");  // ends what an earlier user may have begun
  for (const double until_s = now_s() + kRest_s; now_s() < until_s;) next_line(until_s);
  command("C");  // refused by one that is closed already
  const std::string rate{'S', wire::slcan_rate(address.bit_rate).value()};
  if (command(rate) == Answer::refusal)
    stream_.fail(
        fmt::format("the adapter refuses {}, expected one that has {} bit/s", rate, address.bit_rate));
  if (command(kOpen) == Answer::refusal)
    stream_.fail("the adapter refuses to open its bus, expected one that is free");
}

SlcanLink::~SlcanLink() {
  try {
    stream_.write("C\r");
  } catch (const std::exception&) {  // the adapter is gone: nothing is left to close
  }
}

void SlcanLink::send(const CanFrame& frame) {
  while (unanswered_.size() >= kAhead && await_answer()) continue;
  offer_again();
  put(frame);
}

std::optional<CanFrame> SlcanLink::receive(double timeout_s) {
  const double until_s = now_s() + timeout_s;
  while (arrived_.empty()) {
    const std::optional<std::string> line = next_line(until_s);
    if (!line) return std::nullopt;
    take(*line);
    offer_again();
  }
  const CanFrame frame = arrived_.front();
  arrived_.pop_front();
  return frame;
}

void SlcanLink::put(const CanFrame& frame) {
  stream_.write(wire::slcan_line(frame));
  if (answers_) unanswered_.push_back(frame);
}

/// An answer is to the oldest frame that has none; everything else is a frame of the bus, or no slcan and passed over.
void SlcanLink::take(const std::string& line) {
  const std::string_view text = std::string_view(line).substr(0, line.size() - 1);
  const bool refusal = line.front() == wire::kSlcanRefused;
  if (!refusal && !text.empty() && text != "z" && text != "Z") {
    if (const std::optional<CanFrame> frame = wire::parse_slcan(text)) arrived_.push_back(*frame);
    return;
  }
  if (unanswered_.empty()) {
    if (refusal) stream_.fail("the adapter refused a frame, expected room in its queue");
    return;
  }
  if (refusal) refused_.push_back(unanswered_.front());
  unanswered_.pop_front();
}

/// Waits for the answer to the oldest frame without one; false where none comes: this adapter gives none.
bool SlcanLink::await_answer() {
  const std::size_t before = unanswered_.size();
  const double until_s = now_s() + kTaken_s;
  while (unanswered_.size() == before) {
    const std::optional<std::string> line = next_line(until_s);
    if (!line) {
      answers_ = false;
      unanswered_.clear();
      return false;
    }
    take(*line);
  }
  return true;
}

/// Each until it is taken, in their order.
void SlcanLink::offer_again() {
  if (refused_.empty()) return;
  while (!unanswered_.empty() && await_answer()) continue;
  for (double until_s = now_s() + kRefused_s; !refused_.empty();) {
    const std::size_t before = refused_.size();
    put(refused_.front());
    refused_.pop_front();
    const bool taken = !await_answer() || refused_.size() < before;
    if (taken) {
      until_s = now_s() + kRefused_s;
      continue;
    }
    refused_.push_front(refused_.back());
    refused_.pop_back();
    if (now_s() >= until_s) stream_.fail("the adapter refused a frame for 1 s, expected room in its queue");
    for (const double pause_s = now_s() + kPause_s; now_s() < pause_s;) {
      if (const std::optional<std::string> line = next_line(pause_s)) take(*line);
    }
  }
}

/// Frames that come before the bus is asked to open are of an earlier user; one that comes then says that it is open.
SlcanLink::Answer SlcanLink::command(std::string_view text) {
  stream_.write(std::string(text) + wire::kSlcanEnd);
  const double until_s = now_s() + kAnswer_s;
  while (const std::optional<std::string> line = next_line(until_s)) {
    if (line->front() == wire::kSlcanRefused) return Answer::refusal;
    if (line->size() == 1) return Answer::consent;
    if (text == kOpen) {
      buffer_.insert(0, *line);
      return Answer::consent;
    }
  }
  return Answer::silence;
}

/// The next line with its end, or a bell.
std::optional<std::string> SlcanLink::next_line(double until_s) {
  while (true) {
    const std::size_t end = buffer_.find_first_of("\r\a");
    if (end != std::string::npos) {
      // A bell stands for itself, whatever was begun before it.
      std::string line = buffer_[end] == wire::kSlcanRefused ? std::string(1, wire::kSlcanRefused)
                                                             : buffer_.substr(0, end + 1);
      buffer_.erase(0, end + 1);
      return line;
    }
    if (buffer_.size() > kLongest)
      stream_.fail(fmt::format("{} bytes without a line, expected a serial CAN adapter", kLongest));
    const std::string bytes = stream_.read(until_s);
    if (bytes.empty()) return std::nullopt;
    buffer_ += bytes;
  }
}

}  // namespace plenum::host::client
