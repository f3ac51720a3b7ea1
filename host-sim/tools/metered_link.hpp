// A link that counts what the bus carries.
#pragma once

#include <cstdint>

#include "host-sim/client/link.hpp"
#include "host-sim/ports/can_frame_bits.hpp"

namespace plenum::host::tools {

class MeteredLink final : public client::Link {
 public:
  /// `link` must outlive this one.
  explicit MeteredLink(client::Link& link) : link_(link) {}

  void send(const client::CanFrame& frame) override {
    count(frame);
    link_.send(frame);
  }
  std::optional<client::CanFrame> receive(double timeout_s) override {
    std::optional<client::CanFrame> frame = link_.receive(timeout_s);
    if (frame) count(*frame);
    return frame;
  }
  double now_s() const override { return link_.now_s(); }

  /// Of frames sent and received so far, stuff bits and the pause behind each included. Error frames and frames sent again
  /// are not among them: no link shows those.
  std::uint64_t busy_bits() const { return busy_bits_; }

 private:
  void count(const client::CanFrame& frame) {
    busy_bits_ += ports::frame_bits(frame) + ports::kIntermissionBits;
  }

  client::Link& link_;
  std::uint64_t busy_bits_ = 0;
};

}  // namespace plenum::host::tools
