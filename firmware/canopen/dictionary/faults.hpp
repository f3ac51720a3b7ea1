// Objects 2830h and 2831h (own): what the board does about each of its faults, as the supervisor has it, and which of them stand.
//
// Read only: a reaction belongs to the proof that no fault lets a chamber go on unwatched (safety/README.md), and is
// no setting.
#pragma once

#include "firmware/canopen/dictionary/rows.hpp"
#include "firmware/safety/faults.hpp"

namespace plenum::canopen::dictionary {

constexpr std::uint32_t kOfAChamber = 1U << 24;
constexpr std::uint32_t kClearsByItself = 1U << 25;

/// Sub-index k is the k-th fault in order of priority: code | reaction << 16 | traits.
inline Abort read_fault_reaction(const Device&, Place at, std::uint32_t& bits) noexcept {
  const safety::FaultSpec& fault = safety::fault_table()[at.sub - std::size_t{1}];
  bits = fault.code | static_cast<std::uint32_t>(fault.reaction) << 16;
  if (fault.scope == safety::Scope::chamber) bits |= kOfAChamber;
  if (fault.clears == safety::Clears::by_itself) bits |= kClearsByItself;
  return Abort::none;
}

/// The board's, of no chamber, come last.
inline Abort read_standing_faults(const Device& device, Place at, std::uint32_t& bits) noexcept {
  bits = device.image.standing_faults[at.sub % device.image.standing_faults.size()];
  return Abort::none;
}

inline constexpr Entry kFaultRows[] = {
    highest<safety::kFaults>(object::kFaultReactions, kOnce, "Fault reactions, the most urgent first"),
    value(object::kFaultReactions, {1, safety::kFaults}, kOnce,
          "Code, reaction in byte 2, flags in byte 3: fault", unsigned32, constant, no, kAny,
          read_fault_reaction),
    highest<config::kChambers + 1>(object::kStandingFaults, kOnce,
                                   "Standing faults, bit k - 1 that of 2830h:k"),
    value(object::kStandingFaults, {1, config::kChambers}, kOnce, "At a chamber: faults", unsigned32,
          read_only, transmit, kAny, read_standing_faults),
    value(object::kStandingFaults, config::kChambers + 1, kOnce, "At the board: faults", unsigned32,
          read_only, transmit, kAny, read_standing_faults),
};

}  // namespace plenum::canopen::dictionary
