#include "firmware/canopen/error_reports.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::canopen {
namespace {

using safety::FaultSet;

/// Where StandingFaults has a chamber, counted from 1 as emergencies do, or the board, which is their 0.
constexpr std::size_t place(std::uint8_t chamber) noexcept {
  return chamber == 0 ? config::kChambers : chamber - std::size_t{1};
}

/// One fault at one place.
struct Standing {
  FaultSet fault = 0;
  std::size_t at = 0;
};

/// The most urgent, at the board before a chamber: what error_state() shows. None where no fault stands.
Standing most_urgent(const StandingFaults& faults) noexcept {
  FaultSet anywhere = 0;
  for (const FaultSet at_place : faults) anywhere |= at_place;
  const FaultSet fault = anywhere & (0U - anywhere);
  for (std::uint8_t chamber = 0; chamber <= config::kChambers; ++chamber) {
    if ((faults[place(chamber)] & fault) != 0) return {fault, place(chamber)};
  }
  return {};
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
  return true;
}

/// Those that have risen and are not the most urgent, by urgency. Returns whether a message has gone out.
bool ErrorReports::tell_others(Device& device, TransmitQueue& queue) noexcept {
  const StandingFaults& faults = device.image.standing_faults;
  FaultSet risen = 0;
  for (std::size_t i = 0; i < told_.size(); ++i) risen |= faults[i] & ~told_[i] & safety::kAllFaults;
  int told = 0;
  for (; risen != 0; risen &= risen - 1) {
    const FaultSet fault = risen & (0U - risen);
    const std::uint16_t code = safety::fault_table()[static_cast<std::size_t>(std::countr_zero(risen))].code;
    for (std::uint8_t chamber = 0; chamber <= config::kChambers; ++chamber) {
      if ((faults[place(chamber)] & ~told_[place(chamber)] & fault) == 0) continue;
      const ErrorState error{code, error_state(device.image).error_register, chamber};
      if (told == kMostATick || !tell(error, device, queue)) return told != 0;
      device.history.push(error);
      told_[place(chamber)] |= fault;
      ++told;
    }
  }
  return told != 0;
}

void ErrorReports::step(Device& device, TransmitQueue& queue) noexcept {
  const StandingFaults& faults = device.image.standing_faults;
  const ErrorState before = reported_;
  const FaultSet may_flicker = device.image.error_code != 0 ? safety::clearing_by_themselves() : FaultSet{0};
  for (std::size_t i = 0; i < told_.size(); ++i) told_[i] &= faults[i] | may_flicker;
  if (!tell_most_urgent(device, queue)) return;
  const Standing first = most_urgent(faults);
  const bool known = (told_[first.at] & first.fault) != 0;
  told_[first.at] |= first.fault;
  const bool others = tell_others(device, queue);
  const bool changed = reported_.code != before.code || reported_.chamber != before.chamber;
  if (changed && reported_.code != 0 && !known) device.history.push(reported_);
  if (!others) return;
  untold_ = true;  // and if only in the next tick
  tell_most_urgent(device, queue);
}

}  // namespace plenum::canopen
