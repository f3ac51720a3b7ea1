// The messages of socketcand: CAN frames as text over TCP, each message between '<' and '>'.
//
//   server  < hi >             client  < open can0 >
//   server  < ok >             client  < rawmode >
//   server  < ok >             then both ways:
//   client  < send 123 2 1 f1 >                     length and bytes in hex, unpadded
//   server  < frame 123 23.424242 01F1 >            seconds of its clock, bytes in hex without spaces
//   server  < error 004 23.424242 >                 an error frame of its bus: class of error, time
//   server  < error unknown command >               what it did not understand
//
// In bcmmode, the mode after open, and in controlmode:
//   client  < subscribe 0 0 123 >  < unsubscribe 123 >       seconds and microseconds between two frames at least
//   client  < filter 0 0 123 1 ff >                          frames whose bits under the mask have changed
//   client  < add 1 0 123 2 1 f1 >  < update 123 2 1 f2 >  < delete 123 >     a frame each second
//   client  < statistics 1000 >    server  < stat 80 10 8 1 >     each 1000 ms: bytes and frames received, and sent
//
// An identifier of eight digits is a 29-bit one. There is no message for a remote frame.
// Source: doc/protocol.md and src/state_raw.c of github.com/linux-can/socketcand.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/ports/can_bus.hpp"

namespace plenum::host::wire {

using plenum::ports::CanFrame;

inline constexpr std::uint16_t kSocketcandPort = 29536;
inline constexpr std::size_t kChannelLength = 16;  ///< longest name of a bus

/// What the server writes for a frame on its bus. The frame must not be a remote one.
std::string frame_message(const CanFrame& frame, std::uint64_t time_us);
/// What a client writes for a frame to send. The frame must not be a remote one.
std::string send_message(const CanFrame& frame);

/// The words of "< word word >".
std::vector<std::string_view> words_of(std::string_view message);

/// A frame without data that has the identifier of this word: eight digits, or a value above 7FFh, are a 29-bit one
/// (clients leave leading zeros out). Empty for what is none.
std::optional<CanFrame> parse_identifier(std::string_view word);
/// The frame of "frame ID TIME BYTES", the bytes with or without spaces between them; empty for other words, and for
/// what is no frame: an identifier above 29 bits, more than eight bytes, half a byte.
std::optional<CanFrame> parse_frame(const std::vector<std::string_view>& words);
/// The frame of "ID LENGTH BYTES", as in send, add, update and filter; empty as above, and when the length is not the number of
/// bytes.
std::optional<CanFrame> parse_content(std::span<const std::string_view> words);
/// That of "send ID LENGTH BYTES".
std::optional<CanFrame> parse_send(const std::vector<std::string_view>& words);
/// "SECONDS MICROSECONDS", decimal, up to some hours; empty for what is none.
std::optional<std::uint64_t> parse_interval_us(std::string_view seconds, std::string_view microseconds);

/// Cuts a stream of bytes, however it comes in pieces, into messages. What stands between messages is passed over.
class MessageReader {
 public:
  /// Returns false when the bytes are no socketcand: more than kLongest of them without a whole message.
  bool append(std::string_view bytes);
  /// The next whole message, from '<' to '>'.
  std::optional<std::string> next();

  static constexpr std::size_t kLongest = 1024;

 private:
  std::string buffer_;
};

}  // namespace plenum::host::wire
