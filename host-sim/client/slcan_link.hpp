// A link over a serial CAN adapter that speaks slcan (host-sim/wire/slcan.hpp). No thread.
//
// Not every adapter answers commands: silence is taken for consent, a bell is not. The line's own speed is 115200 baud, which
// adapters on USB do not look at.
#pragma once

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

  /// Throws std::runtime_error when the adapter is gone or takes nothing.
  void send(const CanFrame& frame) override;
  /// Throws std::runtime_error when the adapter is gone or has refused a frame.
  std::optional<CanFrame> receive(double timeout_s) override;
  double now_s() const override { return stream_.now_s(); }

 private:
  enum class Answer { silence, consent, refusal };

  Answer command(std::string_view text);
  std::optional<std::string> next_line(double until_s);

  ByteStream stream_;
  std::string buffer_;
};

}  // namespace plenum::host::client
