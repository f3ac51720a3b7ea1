// A PC and one board on a simulated bus: the board's tick runs every 10 ms of virtual time. Its controller is
// a stand-in of the few lines below; node, parameter slots, bus and client are the real ones.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>

#include "firmware/canopen/node.hpp"
#include "firmware/config/parameter_slots.hpp"
#include "host-sim/client/link.hpp"
#include "host-sim/ports/simulated_bus.hpp"

namespace plenum::host::client {

class BoardOnBus : public Link {
 public:
  static constexpr std::uint64_t kTick_ns = 10'000'000;
  static constexpr std::size_t kDepth = ports::SimulatedBus::Config{}.transmit_depth;

  explicit BoardOnBus(std::uint8_t node_id = 5)
      : pc(bus.attach("pc")),
        board(bus.attach("board")),
        node(canopen::Config{.node_id = node_id, .identity = {.vendor_id = 1, .product_code = 2}}, image,
             slots, settings, recorder) {}

  // Link
  void send(const CanFrame& frame) override {
    const std::uint64_t until_ns = bus.now_ns() + kTick_ns;
    while (!pc.send(frame)) {
      if (bus.now_ns() >= until_ns) throw std::runtime_error("pc: transmit queue full for a tick");
      advance(until_ns);
    }
  }
  std::optional<CanFrame> receive(double timeout_s) override {
    const auto until_ns = bus.now_ns() + static_cast<std::uint64_t>(std::llround(timeout_s * 1.0e9));
    CanFrame frame;
    while (!pc.receive(frame)) {
      if (bus.now_ns() >= until_ns) return std::nullopt;
      advance(until_ns);
    }
    return frame;
  }
  double now_s() const override { return bus.now_s(); }

  /// Runs to the next delivery or tick, at most to `until_ns`.
  void advance(std::uint64_t until_ns) {
    const bool delivered = bus.run_to_next_delivery(std::min(until_ns, next_tick_ns));
    hear();
    if (!delivered && bus.now_ns() == next_tick_ns) {
      next_tick_ns += kTick_ns;
      slots.apply_at_tick_edge();
      control();
      node.tick(kTick_ns / 1000);
    }
    // what the controller has no room for stays with the node
    for (CanFrame frame; board.waiting_to_send() < kDepth && node.next_frame(frame);) {
      if (!deaf) board.send(frame);
    }
  }
  void run_ticks(int ticks) {
    const std::uint64_t until_ns = next_tick_ns + static_cast<std::uint64_t>(ticks - 1) * kTick_ns;
    while (bus.now_ns() < until_ns) advance(until_ns);
    advance(until_ns + 1);
  }

  ports::SimulatedBus bus;
  ports::SimulatedCanPort& pc;
  ports::SimulatedCanPort& board;
  canopen::ProcessImage image;
  config::ParameterSlots slots;
  config::SettingsDesk settings;
  telemetry::Recorder recorder;
  canopen::Node node;
  std::uint64_t next_tick_ns = kTick_ns;
  bool deaf = false;                ///< the board says nothing
  std::function<void()> each_tick;  ///< runs after the stand-in for the controller

 private:
  void hear() {
    for (CanFrame frame; board.receive(frame);) node.receive(frame);
  }
  /// The state follows the control word a tick later; an error lasts until a rising edge of R.
  void control() {
    ++image.tick_count;
    const auto wanted = static_cast<std::uint16_t>(image.control_word & canopen::word::kStateMask);
    const bool reset = (image.control_word & canopen::word::kResetFault) != 0;
    if (reset && !reset_before_ && clears) image.error_code = 0;
    reset_before_ = reset;
    image.status_word =
        image.error_code != 0 ? std::uint16_t{1} : static_cast<std::uint16_t>(wanted | canopen::word::kReady);
    if (each_tick) each_tick();
  }
  bool reset_before_ = false;

 public:
  bool clears = true;  ///< whether a fault reset works
};

}  // namespace plenum::host::client
