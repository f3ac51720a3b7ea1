// A link over a socketcand server: a daemon in front of a real bus, or `plenum sim`.
//
// No thread. The link's time is this machine's monotonic clock; the server's stamps are told beside it. Error frames of the server's bus
// are passed over.
#pragma once

#include "host-sim/client/bus_address.hpp"
#include "host-sim/client/byte_stream.hpp"

namespace plenum::host::client {

class SocketcandLink final : public Link {
 public:
  /// Connects, opens the channel and switches to raw mode. Throws std::runtime_error when the server is not reached,
  /// says no, or has not answered within `timeout_s`.
  explicit SocketcandLink(const SocketcandAddress& address, double timeout_s = 5.0);

  /// Throws std::runtime_error for a remote frame, which the protocol does not know, when the server is gone, and when
  /// it takes nothing.
  void send(const CanFrame& frame) override;
  /// Throws std::runtime_error when the server is gone or tells an error, once the frames before it are taken.
  std::optional<CanFrame> receive(double timeout_s) override;
  double now_s() const override { return stream_.now_s(); }
  /// As the server writes it, with six decimals.
  std::optional<std::uint64_t> stamp_us() const override { return stamp_us_; }

 private:
  void expect(const char* word, const std::string& after, double until_s);
  std::optional<std::string> next_message(double until_s);

  ByteStream stream_;
  wire::MessageReader reader_;
  std::optional<std::uint64_t> stamp_us_;
};

}  // namespace plenum::host::client
