// A CAN bus inside one program, on virtual time: arbitration, exact frame lengths, faults on demand.
//
// When the bus is idle, the frames at the heads of the nodes' transmit queues arbitrate by identifier; the
// winner occupies the bus for its very bit count and reaches every other node at its end; three bits of
// intermission follow. A node's queue is first in, first out, as that of a Linux network device is: an urgent
// frame waits behind its own node's earlier ones. Times are in ns since the bus was made. The same calls give
// the same frames at the same times, always.
//
// Not modelled: bit errors, retransmission, and the missing acknowledge of a node that is alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "firmware/ports/can_bus.hpp"
#include "host-sim/ports/can_frame_bits.hpp"

namespace plenum::host::ports {

using plenum::ports::CanFrame;
using plenum::ports::CanState;

class SimulatedBus;

/// One node's controller. Made by SimulatedBus::attach(), which keeps it.
class SimulatedCanPort final : public plenum::ports::CanBus {
 public:
  SimulatedCanPort(SimulatedBus& bus, std::string name, std::size_t number, std::size_t transmit_depth,
                   std::size_t receive_depth);

  /// Returns false when the queue is full, the node is off the bus, or the frame is none (identifier or
  /// length too large).
  bool send(const CanFrame& frame) noexcept override;
  bool receive(CanFrame& frame) noexcept override;
  CanState state() const noexcept override { return state_; }
  std::uint32_t lost() const noexcept override { return static_cast<std::uint32_t>(receive_overflows_); }

  /// Fault injection. Bus-off empties the transmit queue; the node neither sends nor hears until it is active
  /// again.
  void set_state(CanState state) noexcept;

  const std::string& name() const { return name_; }
  std::size_t number() const { return number_; }
  /// Frames that found this node's receive queue full and are lost to it.
  std::uint64_t receive_overflows() const { return receive_overflows_; }
  std::size_t waiting_to_send() const { return transmit_.size(); }

 private:
  friend class SimulatedBus;

  struct Queued {
    CanFrame frame;
    std::uint64_t since_ns = 0;
    std::uint32_t key = 0;
  };

  /// A queue in a ring that never moves its memory.
  template <class T>
  class Ring {
   public:
    explicit Ring(std::size_t depth) : items_(depth) {}
    bool full() const { return size_ == items_.size(); }
    std::size_t size() const { return size_; }
    void push(const T& item) { items_[wrap(first_ + size_++)] = item; }
    const T& front() const { return items_[first_]; }
    void pop() {
      first_ = wrap(first_ + 1);
      --size_;
    }
    void clear() { size_ = 0; }

   private:
    std::size_t wrap(std::size_t i) const { return i >= items_.size() ? i - items_.size() : i; }
    std::vector<T> items_;
    std::size_t first_ = 0;
    std::size_t size_ = 0;
  };

  SimulatedBus& bus_;
  std::string name_;
  std::size_t number_;
  CanState state_ = CanState::error_active;
  Ring<Queued> transmit_;
  Ring<CanFrame> receive_;
  std::uint64_t receive_overflows_ = 0;
};

/// A frame that has crossed the bus.
struct Delivery {
  CanFrame frame;
  std::size_t sender = 0;  ///< number of its port
  std::uint64_t queued_ns = 0;
  std::uint64_t end_ns = 0;  ///< end of frame: when every other node has it
  unsigned bits = 0;         ///< on the wire, stuff bits included, intermission not
  bool dropped = false;      ///< by fault injection: it took its time on the bus, and no node got it
};

class SimulatedBus {
 public:
  struct Config {
    std::uint32_t bit_rate = 1'000'000;  ///< [bit/s]; the bit time must be a whole number of ns
    std::size_t transmit_depth = 64;     ///< frames a node can queue
    std::size_t receive_depth = 1024;
    bool worst_case_stuffing =
        false;  ///< every frame as long as its like can be: a load that holds for any data
  };

  struct Counters {
    std::uint64_t frames = 0;
    std::uint64_t bits = 0;     ///< intermission included
    std::uint64_t busy_ns = 0;  ///< intermission included
    std::uint64_t dropped = 0;
    std::uint64_t collisions = 0;  ///< arbitrations that two nodes entered with the same identifier
  };

  struct IdentifierCounters {
    std::uint64_t frames = 0;
    std::uint64_t worst_latency_ns = 0;  ///< from send() to the end of frame
  };

  SimulatedBus();
  /// Throws std::invalid_argument when the bit rate does not give a whole number of ns a bit.
  explicit SimulatedBus(const Config& config);
  SimulatedBus(const SimulatedBus&) = delete;
  SimulatedBus& operator=(const SimulatedBus&) = delete;

  /// A new node, named for people. The reference holds as long as the bus lives.
  SimulatedCanPort& attach(std::string name);

  std::uint64_t now_ns() const { return now_ns_; }
  double now_s() const { return 1.0e-9 * static_cast<double>(now_ns_); }
  std::uint64_t bit_ns() const { return bit_ns_; }

  /// Runs the bus up to `time_ns`, which must not lie in the past. `on_delivery(const Delivery&)` is called
  /// at the end of each frame, when the receivers already have it; it may send, and what it sends takes part
  /// in the next arbitration. A frame still on the wire at `time_ns` is delivered by a later call.
  template <class OnDelivery>
  void run_until(std::uint64_t time_ns, OnDelivery&& on_delivery) {
    while (deliver_next(time_ns)) on_delivery(std::as_const(delivery_));
    settle(time_ns);
  }
  void run_until(std::uint64_t time_ns) {
    run_until(time_ns, [](const Delivery&) {});
  }

  /// Runs to the end of the next frame, or to `time_ns` when none ends before. Returns whether one was
  /// delivered.
  bool run_to_next_delivery(std::uint64_t time_ns) {
    if (deliver_next(time_ns)) return true;
    settle(time_ns);
    return false;
  }
  /// No frame is on the wire or waits to be.
  bool idle() const { return waiting_ == 0 && !on_wire_; }
  const Delivery& last_delivery() const { return delivery_; }

  /// Fault injection: frames for which `drop(frame, sender)` is true reach nobody. An empty function drops
  /// none.
  void drop_when(std::function<bool(const CanFrame&, std::size_t)> drop) { drop_ = std::move(drop); }

  const Counters& counters() const { return counters_; }
  /// Share of the time so far in which the bus was not idle, 0..1.
  double busy_share() const;
  IdentifierCounters identifier_counters(std::uint32_t id, bool extended = false) const;

 private:
  friend class SimulatedCanPort;

  bool start_next(std::uint64_t time_ns);
  bool deliver_next(std::uint64_t time_ns);
  void settle(std::uint64_t time_ns);

  Config config_;
  std::uint64_t bit_ns_;
  std::uint64_t now_ns_ = 0;
  std::uint64_t idle_at_ns_ = 0;  ///< when the bus is, or was last, free again
  std::vector<std::unique_ptr<SimulatedCanPort>> ports_;
  std::size_t waiting_ = 0;  ///< frames in all transmit queues
  bool on_wire_ = false;
  Delivery delivery_;  ///< on the wire, or the last one delivered
  std::function<bool(const CanFrame&, std::size_t)> drop_;
  Counters counters_;
  std::array<IdentifierCounters, 0x800> standard_{};
  std::unordered_map<std::uint32_t, IdentifierCounters> extended_;
};

}  // namespace plenum::host::ports
