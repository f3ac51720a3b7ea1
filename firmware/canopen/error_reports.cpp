#include "firmware/canopen/error_reports.hpp"

#include <bit>
#include <span>

namespace plenum::canopen {
namespace {

using safety::FaultSet;

/// As emergencies count them: 0 is the board, which comes last in StandingFaults.
constexpr std::size_t owner(std::uint8_t chamber) noexcept {
  return chamber == 0 || chamber > config::kChambers ? config::kChambers : chamber - std::size_t{1};
}

}  // namespace

bool ErrorReports::tell(const ErrorState& error, Device& device, TransmitQueue& queue) noexcept {
  const std::uint32_t cob_id = device.communication.emergency_cob_id;
  if ((cob_id & cob::kInvalid) != 0) return true;
  ports::CanFrame frame;
  frame.id = cob_id & cob::kIdMask;
  frame.length = 8;
  store_le(error.code, std::span(frame.data).first<2>());
  frame.data[2] = error.error_register;
  frame.data[3] = error.chamber;
  return queue.push_emergency(frame);
}

/// A fault of its code stands there and has been told.
bool ErrorReports::is_told(const ErrorState& error) const noexcept {
  for (FaultSet told = told_[owner(error.chamber)]; told != 0; told &= told - 1) {
    if (safety::fault_table()[static_cast<std::size_t>(std::countr_zero(told))].code == error.code)
      return true;
  }
  return false;
}

/// When it changes, for each bus-off (the controller may have held the last message when it went off), and when asked to. Returns
/// false where the ring is full.
bool ErrorReports::tell_most_urgent(Device& device, TransmitQueue& queue) noexcept {
  const ErrorState error = error_state(device.image);
  const bool changed = error.code != reported_.code || error.chamber != reported_.chamber;
  untold_ = (untold_ || (device.image.bus_off && !off_bus_)) && error.code != 0;
  off_bus_ = device.image.bus_off;
  if (!changed && !untold_) return true;
  if (!tell(error, device, queue)) {
    ++device.counters.queue_overflow;
    return false;
  }
  untold_ = false;
  reported_ = error;
  if (changed && error.code != 0 && !is_told(error)) device.history.push(error);
  return true;
}

/// Those that have risen and are not the most urgent, by urgency. Returns whether a message has gone out.
bool ErrorReports::tell_others(Device& device, TransmitQueue& queue) noexcept {
  const ErrorState most_urgent = error_state(device.image);
  FaultSet risen = 0;
  for (std::size_t i = 0; i < told_.size(); ++i) risen |= device.image.standing_faults[i] & ~told_[i];
  bool told = false;
  for (; risen != 0; risen &= risen - 1) {
    const FaultSet fault = risen & ~(risen - 1);
    const std::uint16_t code = safety::fault_table()[static_cast<std::size_t>(std::countr_zero(risen))].code;
    for (std::uint8_t chamber = 0; chamber <= config::kChambers; ++chamber) {
      const std::size_t at = owner(chamber);
      if ((device.image.standing_faults[at] & ~told_[at] & fault) == 0) continue;
      const ErrorState error{code, most_urgent.error_register, chamber};
      if (code != most_urgent.code || chamber != most_urgent.chamber) {
        if (!tell(error, device, queue)) return told;
        device.history.push(error);
        told = true;
      }
      told_[at] |= fault;
    }
  }
  return told;
}

void ErrorReports::step(Device& device, TransmitQueue& queue) noexcept {
  for (std::size_t i = 0; i < told_.size(); ++i) told_[i] &= device.image.standing_faults[i];
  if (!tell_most_urgent(device, queue) || !tell_others(device, queue)) return;
  untold_ = true;  // and if only in the next tick
  tell_most_urgent(device, queue);
}

}  // namespace plenum::canopen
