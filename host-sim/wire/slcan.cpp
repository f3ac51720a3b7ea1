#include "host-sim/wire/slcan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace plenum::host::wire {
namespace {

constexpr std::array<std::uint32_t, 9> kRates{10'000,  20'000,  50'000,  100'000,  125'000,
                                              250'000, 500'000, 800'000, 1'000'000};
constexpr std::size_t kTimeStampDigits = 4;

bool read_hex(std::string_view text, std::uint32_t& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::string slcan_line(const CanFrame& frame) {
  const char kind = frame.remote ? 'r' : 't';
  std::string line = frame.extended ? fmt::format("{}{:08X}", static_cast<char>(kind - 'a' + 'A'), frame.id)
                                    : fmt::format("{}{:03X}", kind, frame.id);
  line += static_cast<char>('0' + frame.length);
  for (std::size_t i = 0; !frame.remote && i < frame.length; ++i)
    line += fmt::format("{:02X}", frame.data[i]);
  return line + kSlcanEnd;
}

std::optional<CanFrame> parse_slcan(std::string_view line) {
  if (line.empty()) return std::nullopt;
  const char kind = line.front();
  CanFrame frame;
  frame.extended = kind == 'T' || kind == 'R';
  frame.remote = kind == 'r' || kind == 'R';
  if (!frame.extended && !frame.remote && kind != 't') return std::nullopt;
  const std::size_t digits = frame.extended ? 8 : 3;
  if (line.size() < digits + 2 || !read_hex(line.substr(1, digits), frame.id) ||
      frame.id > (frame.extended ? 0x1FFF'FFFFU : 0x7FFU)) {
    return std::nullopt;
  }
  const char length = line[digits + 1];
  if (length < '0' || length > '8') return std::nullopt;
  frame.length = static_cast<std::uint8_t>(length - '0');
  line.remove_prefix(digits + 2);
  const std::size_t data_digits = frame.remote ? 0 : 2U * frame.length;
  if (line.size() != data_digits && line.size() != data_digits + kTimeStampDigits) return std::nullopt;
  for (std::size_t i = 0; 2 * i < data_digits; ++i) {
    std::uint32_t byte = 0;
    if (!read_hex(line.substr(2 * i, 2), byte)) return std::nullopt;
    frame.data[i] = static_cast<std::uint8_t>(byte);
  }
  return frame;
}

std::optional<char> slcan_rate(std::uint32_t bit_rate) {
  const auto found = std::find(kRates.begin(), kRates.end(), bit_rate);
  if (found == kRates.end()) return std::nullopt;
  return static_cast<char>('0' + (found - kRates.begin()));
}

}  // namespace plenum::host::wire
