#include "host-sim/ports/simulated_bus.hpp"

#include <algorithm>
#include <stdexcept>

namespace plenum::host::ports {
namespace {

constexpr std::uint64_t kNs_per_s = 1'000'000'000;

}  // namespace

SimulatedCanPort::SimulatedCanPort(SimulatedBus& bus, std::string name, std::size_t number,
                                   std::size_t transmit_depth, std::size_t receive_depth)
    : bus_(bus),
      name_(std::move(name)),
      number_(number),
      transmit_(transmit_depth),
      receive_(receive_depth) {}

bool SimulatedCanPort::send(const CanFrame& frame) noexcept {
  const std::uint32_t id_limit = frame.extended ? 0x2000'0000U : 0x800U;
  if (state_ == CanState::bus_off || transmit_.full() || frame.id >= id_limit || frame.length > 8)
    return false;
  transmit_.push({frame, bus_.now_ns_, arbitration_key(frame)});
  ++bus_.waiting_;
  return true;
}

bool SimulatedCanPort::receive(CanFrame& frame) noexcept {
  if (receive_.size() == 0) return false;
  frame = receive_.front();
  receive_.pop();
  return true;
}

void SimulatedCanPort::set_state(CanState state) noexcept {
  state_ = state;
  if (state != CanState::bus_off) return;
  bus_.waiting_ -= transmit_.size();
  transmit_.clear();
}

SimulatedBus::SimulatedBus() : SimulatedBus(Config{}) {}

SimulatedBus::SimulatedBus(const Config& config) : config_(config), bit_ns_(0) {
  if (config.bit_rate == 0 || kNs_per_s % config.bit_rate != 0) {
    throw std::invalid_argument("simulated bus: bit rate " + std::to_string(config.bit_rate) +
                                " bit/s, expected one that divides 1e9");
  }
  bit_ns_ = kNs_per_s / config.bit_rate;
}

SimulatedCanPort& SimulatedBus::attach(std::string name) {
  ports_.push_back(std::make_unique<SimulatedCanPort>(*this, std::move(name), ports_.size(),
                                                      config_.transmit_depth, config_.receive_depth));
  return *ports_.back();
}

/// Puts the winner of the next arbitration on the wire, if one takes place before `time_ns`.
bool SimulatedBus::start_next(std::uint64_t time_ns) {
  if (waiting_ == 0) return false;
  std::uint64_t start_ns = UINT64_MAX;
  for (const auto& port : ports_) {
    if (port->transmit_.size() != 0) start_ns = std::min(start_ns, port->transmit_.front().since_ns);
  }
  start_ns = std::max(start_ns, idle_at_ns_);
  if (start_ns >= time_ns) return false;

  SimulatedCanPort* winner = nullptr;
  bool collision = false;
  for (const auto& port : ports_) {
    if (port->transmit_.size() == 0 || port->transmit_.front().since_ns > start_ns) continue;
    if (winner == nullptr || port->transmit_.front().key < winner->transmit_.front().key) {
      winner = port.get();
      collision = false;
    } else if (port->transmit_.front().key == winner->transmit_.front().key) {
      collision = true;  // the node that was attached first goes first
    }
  }
  const auto& queued = winner->transmit_.front();
  delivery_.frame = queued.frame;
  delivery_.sender = winner->number_;
  delivery_.queued_ns = queued.since_ns;
  delivery_.bits = config_.worst_case_stuffing ? most_frame_bits(queued.frame) : frame_bits(queued.frame);
  delivery_.end_ns = start_ns + delivery_.bits * bit_ns_;
  delivery_.dropped = drop_ && drop_(queued.frame, winner->number_);
  winner->transmit_.pop();
  --waiting_;

  const std::uint64_t bits = delivery_.bits + kIntermissionBits;
  idle_at_ns_ = start_ns + bits * bit_ns_;
  ++counters_.frames;
  counters_.bits += bits;
  counters_.busy_ns += bits * bit_ns_;
  if (collision) ++counters_.collisions;
  if (delivery_.dropped) ++counters_.dropped;
  on_wire_ = true;
  return true;
}

bool SimulatedBus::deliver_next(std::uint64_t time_ns) {
  if (!on_wire_ && !start_next(time_ns)) return false;
  if (delivery_.end_ns > time_ns) return false;
  on_wire_ = false;
  now_ns_ = delivery_.end_ns;
  const CanFrame& frame = delivery_.frame;
  IdentifierCounters& identifier = frame.extended ? extended_[frame.id] : standard_[frame.id];
  ++identifier.frames;
  identifier.worst_latency_ns = std::max(identifier.worst_latency_ns, now_ns_ - delivery_.queued_ns);
  if (delivery_.dropped) return true;
  for (const auto& port : ports_) {
    if (port->number_ == delivery_.sender || port->state_ == CanState::bus_off) continue;
    if (port->receive_.full()) {
      ++port->receive_overflows_;
    } else {
      port->receive_.push(frame);
    }
  }
  return true;
}

void SimulatedBus::settle(std::uint64_t time_ns) {
  if (time_ns < now_ns_) {
    throw std::logic_error("simulated bus: asked to run to " + std::to_string(time_ns) +
                           " ns, expected at least " + std::to_string(now_ns_) + " ns, which is now");
  }
  now_ns_ = time_ns;
}

double SimulatedBus::busy_share() const {
  if (now_ns_ == 0) return 0.0;
  const std::uint64_t ahead_ns =
      idle_at_ns_ > now_ns_ ? idle_at_ns_ - now_ns_ : 0;  // of a frame still on the wire
  return static_cast<double>(counters_.busy_ns - ahead_ns) / static_cast<double>(now_ns_);
}

SimulatedBus::IdentifierCounters SimulatedBus::identifier_counters(std::uint32_t id, bool extended) const {
  if (!extended) return id < standard_.size() ? standard_[id] : IdentifierCounters{};
  const auto found = extended_.find(id);
  return found == extended_.end() ? IdentifierCounters{} : found->second;
}

}  // namespace plenum::host::ports
