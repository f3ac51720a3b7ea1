#include "host-sim/wire/socketcand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace plenum::host::wire {
namespace {

constexpr std::size_t kExtendedDigits = 8;

std::string identifier(const CanFrame& frame) {
  return frame.extended ? fmt::format("{:08X}", frame.id) : fmt::format("{:03X}", frame.id);
}

std::optional<std::uint32_t> number(std::string_view text, int base) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}
std::optional<std::uint32_t> hex(std::string_view text) {
  return number(text, 16);
}

bool add_byte(CanFrame& frame, std::string_view text) {
  const auto value = hex(text);
  if (!value || text.size() > 2 || frame.length == frame.data.size()) return false;
  frame.data[frame.length++] = static_cast<std::uint8_t>(*value);
  return true;
}

}  // namespace

std::string frame_message(const CanFrame& frame, std::uint64_t time_us) {
  std::string text =
      fmt::format("< frame {} {}.{:06} ", identifier(frame), time_us / 1'000'000, time_us % 1'000'000);
  for (std::size_t i = 0; i < frame.length; ++i) text += fmt::format("{:02X}", frame.data[i]);
  return text + " >";
}

std::string send_message(const CanFrame& frame) {
  std::string text = fmt::format("< send {} {:x}", identifier(frame), frame.length);
  for (std::size_t i = 0; i < frame.length; ++i) text += fmt::format(" {:x}", frame.data[i]);
  return text + " >";
}

std::vector<std::string_view> words_of(std::string_view message) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBetween = "<> ";
  for (std::size_t begin = 0;
       (begin = message.find_first_not_of(kBetween, begin)) != std::string_view::npos;) {
    const std::size_t end = std::min(message.find_first_of(kBetween, begin), message.size());
    words.push_back(message.substr(begin, end - begin));
    begin = end;
  }
  return words;
}

std::optional<CanFrame> parse_identifier(std::string_view word) {
  const auto id = hex(word);
  if (!id || word.size() > kExtendedDigits || *id > 0x1FFF'FFFFU) return std::nullopt;
  return CanFrame{.id = *id, .extended = word.size() == kExtendedDigits || *id > 0x7FFU};
}

std::optional<CanFrame> parse_frame(const std::vector<std::string_view>& words) {
  if (words.size() < 3 || words[0] != "frame") return std::nullopt;
  std::optional<CanFrame> frame = parse_identifier(words[1]);
  if (!frame) return std::nullopt;
  for (std::size_t i = 3; i < words.size(); ++i) {
    std::string_view bytes = words[i];
    if (bytes.size() % 2 != 0) return std::nullopt;
    for (; !bytes.empty(); bytes.remove_prefix(2)) {
      if (!add_byte(*frame, bytes.substr(0, 2))) return std::nullopt;
    }
  }
  return frame;
}

std::optional<CanFrame> parse_content(std::span<const std::string_view> words) {
  if (words.size() < 2) return std::nullopt;
  std::optional<CanFrame> frame = parse_identifier(words[0]);
  if (!frame) return std::nullopt;
  const auto length = hex(words[1]);
  if (!length || *length != words.size() - 2) return std::nullopt;
  for (const std::string_view byte : words.subspan(2)) {
    if (!add_byte(*frame, byte)) return std::nullopt;
  }
  return frame;
}

std::optional<CanFrame> parse_send(const std::vector<std::string_view>& words) {
  if (words.empty() || words[0] != "send") return std::nullopt;
  return parse_content(std::span(words).subspan(1));
}

std::optional<std::uint64_t> parse_interval_us(std::string_view seconds, std::string_view microseconds) {
  constexpr std::uint32_t kMost_s = 86'400;
  const auto whole_s = number(seconds, 10), part_us = number(microseconds, 10);
  if (!whole_s || !part_us || *whole_s > kMost_s) return std::nullopt;
  return std::uint64_t{1'000'000} * *whole_s + *part_us;
}

bool MessageReader::append(std::string_view bytes) {
  buffer_ += bytes;
  const std::size_t whole = buffer_.rfind('>');
  return buffer_.size() - (whole == std::string::npos ? 0 : whole + 1) <= kLongest;
}

std::optional<std::string> MessageReader::next() {
  for (std::size_t end = 0; (end = buffer_.find('>')) != std::string::npos;) {
    const std::size_t begin = buffer_.rfind('<', end);
    std::string message = begin == std::string::npos ? std::string() : buffer_.substr(begin, end + 1 - begin);
    buffer_.erase(0, end + 1);
    if (!message.empty()) return message;
  }
  return std::nullopt;
}

}  // namespace plenum::host::wire
