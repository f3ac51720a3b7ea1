// A link over a serial CAN adapter that speaks slcan (host-sim/wire/slcan.hpp). No thread.
//
// Not every adapter answers commands: silence is taken for consent, a bell is not. One that answers a frame with a bell had no
// room in its queue: it is offered the frame again, after those that it has. The line's own speed is 115200 baud, which adapters
// on USB do not look at.
#pragma once

#include <deque>

#include "host-sim/client/bus_address.hpp"
#include "host-sim/client/byte_stream.hpp"

namespace plenum::host::client {

class SlcanLink final : public Link {
 public:
  /// Opens the terminal, sets the bit rate and opens the bus. Throws std::runtime_error when that cannot be done or the adapter
  /// refuses.
  explicit SlcanLink(const SlcanAddress& address);
  /// Closes the bus.
  ~SlcanLink() override;
  SlcanLink(const SlcanLink&) = delete;
  SlcanLink& operator=(const SlcanLink&) = delete;

  /// Waits while the adapter has not answered the last few. Throws std::runtime_error when it is gone, takes nothing, or has
  /// refused a frame for a second.
  void send(const CanFrame& frame) override;
  /// Throws std::runtime_error as send() does.
  std::optional<CanFrame> receive(double timeout_s) override;
  double now_s() const override { return stream_.now_s(); }
  std::optional<std::uint32_t> bit_rate() const override { return bit_rate_; }

 private:
  enum class Answer { silence, consent, refusal };

  Answer command(std::string_view text);
  std::optional<std::string> next_line(double until_s);
  void put(const CanFrame& frame);
  void take(const std::string& line);
  bool await_answer();
  void offer_again();

  ByteStream stream_;
  std::uint32_t bit_rate_;
  std::string buffer_;
  std::deque<CanFrame> arrived_;
  std::deque<CanFrame> unanswered_;  ///< sent, the oldest first
  std::deque<CanFrame> refused_;     ///< to be offered again, the oldest first
  bool answers_ = true;              ///< until it is seen not to
};

}  // namespace plenum::host::client
