// Any text from a socketcand server or client, a serial adapter, or a log of candump.
//
// What is taken for a frame is one, and is written as text that reads as the same frame; a stream says the same in pieces as whole.
//
// An input is a byte, the size of a piece less one, and the text: read as each of the three.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/wire/candump.hpp"
#include "host-sim/wire/slcan.hpp"
#include "host-sim/wire/socketcand.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace plenum::host::wire;
using plenum::fuzz::require;

void require_whole(const CanFrame& frame) {
  require(frame.length <= frame.data.size(), "a frame has up to eight bytes");
  require(frame.id <= (frame.extended ? 0x1FFF'FFFFU : 0x7FFU), "an identifier has 11 or 29 bits");
  for (std::size_t i = frame.remote ? 0 : frame.length; i < frame.data.size(); ++i)
    require(frame.data[i] == 0, "bytes beyond a frame's length are 0");
}

/// The messages of a stream that comes in pieces; empty where it is none of socketcand.
std::optional<std::vector<std::string>> messages_of(std::string_view text, std::size_t piece) {
  std::vector<std::string> messages;
  MessageReader reader;
  for (; !text.empty(); text.remove_prefix(std::min(piece, text.size()))) {
    if (!reader.append(text.substr(0, piece))) return std::nullopt;
    while (std::optional<std::string> message = reader.next()) messages.push_back(*std::move(message));
  }
  return messages;
}

void read_socketcand(std::string_view text, std::size_t piece) {
  const auto messages = messages_of(text, piece);
  if (!messages) return;
  require(messages_of(text, text.size() + 1) == messages, "a stream says the same in pieces as whole");
  constexpr std::uint64_t kTime_us = 23'424'242;
  for (const std::string& message : *messages) {
    const auto words = words_of(message);
    if (const auto frame = parse_send(words)) {
      require_whole(*frame);
      require(parse_send(words_of(send_message(*frame))) == frame, "a frame to send reads back");
    }
    if (const auto frame = parse_frame(words)) {
      require_whole(*frame);
      require(parse_frame(words_of(frame_message(*frame, kTime_us))) == frame, "a frame of a bus reads back");
    }
  }
}

void read_slcan(std::string_view line) {
  const auto frame = parse_slcan(line);
  if (!frame) return;
  require_whole(*frame);
  std::string again = slcan_line(*frame);
  require(again.back() == kSlcanEnd, "a line ends");
  again.pop_back();
  require(parse_slcan(again) == frame, "a line of an adapter reads back");
}

void read_candump(std::string_view line) {
  const auto logged = parse_candump(line);
  if (!logged || !logged->classic) return;
  require_whole(logged->frame);
  const auto again = parse_candump(candump_line(logged->time_us, logged->channel, logged->frame));
  require(again && again->time_us == logged->time_us && again->channel == logged->channel &&
              again->frame == logged->frame,
          "a line of a log reads back");
}

template <class Read>
void each_line(std::string_view text, char end, Read read) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find(end));
    read(line);
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text = plenum::fuzz::text_of(data, size).substr(1);
  read_socketcand(text, data[0] + std::size_t{1});
  each_line(text, kSlcanEnd, read_slcan);
  each_line(text, '\n', read_candump);
  return 0;
}
