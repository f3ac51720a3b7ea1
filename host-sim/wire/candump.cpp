#include "host-sim/wire/candump.hpp"

#include <fmt/format.h>

#include <charconv>

#include "host-sim/wire/time_stamp.hpp"

namespace plenum::host::wire {
namespace {

constexpr std::uint32_t kErrorFlag = 0x2000'0000;  ///< CAN_ERR_FLAG of linux/can.h

template <class T>
bool read_number(std::string_view text, T& value, int base) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return error == std::errc() && end == text.data() + text.size();
}

/// Takes the text up to `mark` off the front, and the mark; false when there is none.
bool take_until(std::string_view& text, char mark, std::string_view& taken) {
  const std::size_t at = text.find(mark);
  if (at == std::string_view::npos) return false;
  taken = text.substr(0, at);
  text.remove_prefix(at + 1);
  return true;
}

bool read_data(std::string_view text, CanFrame& frame) {
  if (text.starts_with('R')) {
    frame.remote = true;
    return text.size() == 1 ||
           (text.size() == 2 && read_number(text.substr(1), frame.length, 10) && frame.length <= 8);
  }
  if (text.size() % 2 != 0 || text.size() > 2 * frame.data.size()) return false;
  for (; !text.empty(); text.remove_prefix(2)) {
    if (!read_number(text.substr(0, 2), frame.data[frame.length++], 16)) return false;
  }
  return true;
}

/// What is behind "##": a digit of flags, and up to 64 bytes.
bool is_fd_data(std::string_view text) {
  constexpr std::size_t kMostBytes = 64;
  return text.size() % 2 == 1 && text.size() <= 1 + 2 * kMostBytes &&
         text.find_first_not_of("0123456789ABCDEFabcdef") == std::string_view::npos;
}

}  // namespace

std::string candump_line(std::uint64_t time_us, const std::string& channel, const CanFrame& frame) {
  std::string line = fmt::format("({:010}.{:06}) {} ", time_us / 1'000'000, time_us % 1'000'000, channel);
  line += frame.extended ? fmt::format("{:08X}#", frame.id) : fmt::format("{:03X}#", frame.id);
  if (frame.remote) return line + (frame.length == 0 ? "R" : fmt::format("R{}", frame.length));
  for (std::size_t i = 0; i < frame.length; ++i) line += fmt::format("{:02X}", frame.data[i]);
  return line;
}

std::optional<LoggedFrame> parse_candump(std::string_view line) {
  LoggedFrame logged;
  std::string_view time, channel, identifier;
  if (!line.starts_with('(')) return std::nullopt;
  line.remove_prefix(1);
  if (!take_until(line, ')', time) || !line.starts_with(' ')) return std::nullopt;
  line.remove_prefix(1);
  if (!take_until(line, ' ', channel) || !take_until(line, '#', identifier)) return std::nullopt;
  const std::string_view data = line.substr(0, line.find_first_of(" \r"));
  CanFrame& frame = logged.frame;
  frame.extended = identifier.size() == 8;
  const std::uint32_t largest = frame.extended ? kErrorFlag | 0x1FFF'FFFFU : 0x7FFU;
  if ((identifier.size() != 3 && !frame.extended) || !read_number(identifier, frame.id, 16) ||
      frame.id > largest || channel.empty()) {
    return std::nullopt;
  }
  const std::optional<std::uint64_t> stamp_us = parse_stamp_us(time);
  if (!stamp_us) return std::nullopt;
  logged.time_us = *stamp_us;
  const bool fd = data.starts_with('#');
  if (fd ? !is_fd_data(data.substr(1)) : !read_data(data, frame)) return std::nullopt;
  logged.classic = !fd && (frame.id & kErrorFlag) == 0;
  logged.frames_missing =
      !fd && frame.id == kReceiveOverflow.id && frame.length > 1 && (frame.data[1] & 1U) != 0;
  logged.channel = channel;
  return logged;
}

}  // namespace plenum::host::wire
