// The way from a client to a simulated rig: waiting for a frame runs the rig.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "host-sim/client/link.hpp"
#include "host-sim/rig/rig.hpp"

namespace plenum::host::tools {

class RigLink : public client::Link {
 public:
  /// The rig must outlive the link. `on_tick` is called after each tick of the boards that waiting runs.
  explicit RigLink(rig::Rig& rig, const std::string& name = "master", std::function<void()> on_tick = {})
      : rig_(rig), port_(rig.attach(name)), on_tick_(std::move(on_tick)) {}

  void send(const client::CanFrame& frame) override {
    const std::uint64_t until_ns = rig_.now_ns() + kPatience_ns;
    while (!port_.send(frame)) {
      if (rig_.now_ns() >= until_ns) {
        throw std::runtime_error("the simulated bus took no frame within 0.1 s: its transmit queue is full");
      }
      advance(until_ns);
    }
  }

  std::optional<client::CanFrame> receive(double timeout_s) override {
    const std::uint64_t until_ns = rig_.now_ns() + static_cast<std::uint64_t>(std::llround(timeout_s * 1e9));
    client::CanFrame frame;
    while (true) {
      if (port_.receive(frame)) return frame;
      if (rig_.now_ns() >= until_ns) return std::nullopt;
      advance(until_ns);
    }
  }

  double now_s() const override { return rig_.now_s(); }
  std::optional<std::uint32_t> bit_rate() const override {
    return static_cast<std::uint32_t>(1'000'000'000 / rig_.bus().bit_ns());
  }

 private:
  static constexpr std::uint64_t kPatience_ns = 100'000'000;

  void advance(std::uint64_t until_ns) {
    const std::uint64_t ticks = rig_.ticks();
    rig_.advance(until_ns);
    if (on_tick_ && rig_.ticks() != ticks) on_tick_();
  }

  rig::Rig& rig_;
  ports::SimulatedCanPort& port_;
  std::function<void()> on_tick_;
};

}  // namespace plenum::host::tools
