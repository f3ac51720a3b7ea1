#include "firmware/canopen/error_reports.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::canopen {

using safety::FaultSet;

bool ErrorReports::tell(const ErrorState& error, Device& device, TransmitQueue& queue) noexcept {
  const std::uint32_t cob_id = device.communication.emergency_cob_id;
  if ((cob_id & cob::kInvalid) != 0) return true;
  ports::CanFrame frame;
  frame.id = cob_id & cob::kIdMask;
  frame.length = 8;
  store_le(error.code, std::span(frame.data).first<2>());
  frame.data[2] = error.error_register;
  frame.data[3] = error.chamber;
  if (error.code != kHeartbeatLost) return queue.push_emergency(frame);
  const unsigned silent = device.communication.heartbeats.silent(), untold = silent & ~unsigned{told_silent_};
  const auto entry = static_cast<std::size_t>(std::countr_zero(untold != 0 ? untold : silent));
  if (entry < HeartbeatConsumer::kWatches) frame.data[4] = device.communication.heartbeats.node_id(entry);
  if (!queue.push_emergency(frame)) return false;
  told_silent_ = static_cast<std::uint8_t>(told_silent_ | (untold & (0U - untold)));
  return true;
}

/// Those that have risen and are not the most urgent, by urgency. Returns whether a message has gone out.
bool ErrorReports::tell_others(std::uint8_t error_register, Device& device, TransmitQueue& queue) noexcept {
  const StandingFaults& faults = device.image.standing_faults;
  FaultSet risen = 0;
  for (std::size_t i = 0; i < faults.size(); ++i) risen |= faults[i] & ~told_[i] & safety::kAllFaults;
  int told = 0;
  for (; risen != 0; risen &= risen - 1) {
    const FaultSet fault = risen & (0U - risen);
    const std::uint16_t code = safety::fault_table()[static_cast<std::size_t>(std::countr_zero(risen))].code;
    for (std::size_t i = 0; i < faults.size(); ++i) {
      if ((faults[i] & ~told_[i] & fault) == 0) continue;
      const ErrorState error{code, error_register, static_cast<std::uint8_t>(i)};
      if (told == kMostATick || !tell(error, device, queue)) return told != 0;
      device.history.push(error);
      told_[i] |= fault;
      ++told;
    }
  }
  return told != 0;
}

void ErrorReports::step(Device& device, TransmitQueue& queue) noexcept {
  const StandingFaults& faults = device.image.standing_faults;
  const ErrorState error = error_state(device.image);
  const FaultSet may_flicker = error.code != 0 ? safety::clearing_by_themselves() : FaultSet{0};
  FaultSet anywhere = 0;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    told_[i] &= faults[i] | may_flicker;
    anywhere |= faults[i];
  }

  if ((anywhere & safety::only(safety::Fault::heartbeat_lost)) == 0) told_silent_ = 0;
  const unsigned unnamed = device.communication.heartbeats.silent() & ~unsigned{told_silent_};
  const bool another_silent = error.code == kHeartbeatLost && unnamed != 0;
  // The most urgent: when it changes, for each bus-off (the controller may have held the last message when it went off), for each node
  // that falls silent, and when asked to.
  const bool changed = error.code != reported_.code || error.chamber != reported_.chamber;
  untold_ = (untold_ || another_silent || (device.image.bus_off && !off_bus_)) && error.code != 0;
  off_bus_ = device.image.bus_off;
  if (changed || untold_) {
    if (!tell(error, device, queue)) {
      ++device.counters.queue_overflow;
      return;
    }
    untold_ = false;
    reported_ = error;
  }
  const FaultSet most_urgent = anywhere & (0U - anywhere);
  FaultSet& told_there = told_[error.chamber < told_.size() ? error.chamber : 0];
  const bool known = (told_there & most_urgent) != 0;
  told_there |= most_urgent;

  const bool others = tell_others(error.error_register, device, queue);
  if (changed && error.code != 0 && !known) device.history.push(error);
  if (!others) return;
  untold_ = !tell(error, device, queue);
  if (untold_) ++device.counters.queue_overflow;
}

}  // namespace plenum::canopen
