// A link to a board that answers late by the PC's clock: one in an emulator, whose second lasts longer than the PC's.
#pragma once

#include <memory>
#include <utility>

#include "host-sim/client/link.hpp"

namespace plenum::host::client {

/// Its time passes `patience` times as slowly, so that whoever waits on it waits so much longer, whatever for.
class PatientLink final : public Link {
 public:
  /// `patience` >= 1.
  PatientLink(std::unique_ptr<Link> link, double patience) : link_(std::move(link)), patience_(patience) {}

  void send(const CanFrame& frame) override { link_->send(frame); }
  std::optional<CanFrame> receive(double timeout_s) override { return link_->receive(patience_ * timeout_s); }
  double now_s() const override { return link_->now_s() / patience_; }
  std::uint64_t lost() const override { return link_->lost(); }
  std::optional<std::uint64_t> stamp_us() const override { return link_->stamp_us(); }
  std::optional<std::uint32_t> bit_rate() const override { return link_->bit_rate(); }

 private:
  std::unique_ptr<Link> link_;
  double patience_;
};

}  // namespace plenum::host::client
