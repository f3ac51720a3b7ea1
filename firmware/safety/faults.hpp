// The faults of a board: one table says for each its code, its reaction, how it clears and what to look at.
//
// FaultRegister latches them and answers in the same tick with what 604Eh, 1001h, 1003h, the emergency
// message and the supervisor show; there is no second place where a fault could be known or forgotten.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/config/limits.hpp"
#include "firmware/config/twice.hpp"

namespace plenum::safety {

/// Faults in order of priority, the most urgent first: of several standing faults the first one is reported.
enum class Fault : std::uint8_t {
  emergency_stop,
  hardware,
  over_pressure,
  memory_upset,
  configuration_refused,
  tick_overrun,
  pressure_not_finite,
  pressure_out_of_range,
  pressure_stale,
  pressure_stuck,
  position_not_finite,
  position_out_of_range,
  position_stale,
  no_model,
  stored_set_lost,
  bus_off,
  heartbeat_lost,
  setpoint_timeout,
  supply_low,
  model_residual,
  store_failing,
  can_overrun,
  can_passive,
  model_drift,
  control_deviation,
  pdo_short,
  sync_refused,
  pdo_long,
};

inline constexpr std::size_t kFaults = 28;

/// A set of faults, bit f for fault f.
using FaultSet = std::uint32_t;
static_assert(kFaults <= 32);

/// The table ends behind these. A bit beyond comes of a flag in which one has flipped.
inline constexpr FaultSet kAllFaults = (FaultSet{1} << kFaults) - 1;

constexpr FaultSet only(Fault fault) noexcept {
  return FaultSet{1} << static_cast<unsigned>(fault);
}
constexpr bool holds(FaultSet set, Fault fault) noexcept {
  return (set & only(fault)) != 0;
}

/// What the outputs do while a fault stands, the mildest first.
enum class Reaction : std::uint8_t {
  none,  ///< reported only
  hold,  ///< every chamber regulates to its hold set point (6394h), or stays where that is 0
  safe,  ///< every chamber gets its safe output
  vent   ///< as safe, and the faulty chamber is vented whatever its safe output is
};

enum class Scope : std::uint8_t { board, chamber };

enum class Clears : std::uint8_t {
  by_reset,  ///< latched; on the rising edge of R in 6040h, once its cause has gone
  by_itself  ///< with its cause
};

/// Bits of the error register 1001h (CiA 301).
namespace error_bit {
inline constexpr std::uint8_t kGeneric = 0x01;
inline constexpr std::uint8_t kVoltage = 0x04;
inline constexpr std::uint8_t kCommunication = 0x10;
inline constexpr std::uint8_t kProfile = 0x20;
inline constexpr std::uint8_t kManufacturer = 0x80;
}  // namespace error_bit

struct FaultSpec {
  Fault fault;
  const char* name;
  std::uint16_t code;           ///< 604Eh and the emergency message
  std::uint8_t error_register;  ///< bits of 1001h
  Reaction reaction;
  Scope scope;
  Clears clears;
  const char* blame;  ///< the setting or the cable to look at first
};

/// The whole table, in the order of Fault.
std::span<const FaultSpec, kFaults> fault_table() noexcept;
const FaultSpec& spec(Fault fault) noexcept;
/// Those that clear with their cause, or soon after it.
FaultSet clearing_by_themselves() noexcept;

/// What stands at the end of a tick.
struct FaultReport {
  bool any = false;  ///< some fault stands; the next three describe the most urgent
  Fault fault = Fault::emergency_stop;
  std::uint16_t code = 0;              ///< 604Eh
  std::uint8_t chamber = 0;            ///< its chamber + 1; 0: the whole board
  std::uint8_t error_register = 0;     ///< 1001h, the bits of every standing fault
  Reaction reaction = Reaction::none;  ///< the severest reaction that any standing fault asks for
};

using ChamberFaults = std::array<FaultSet, config::kChambers>;

class FaultRegister {
 public:
  /// No bit has flipped in what stands.
  bool intact() const noexcept;

  /// Ticks in which a fault that clears by itself is remembered, and the next as many: one that flickers is one.
  static constexpr std::uint8_t kFlicker_ticks = 100;

  /// Takes in the causes present in this tick. `reset`: clear what has no cause any more. A fault whose cause is present stands, reset
  /// or not; and so does one that a flipped bit has left in one copy only. What clears by itself does so one to two times kFlicker_ticks
  /// after its cause was last present.
  FaultReport step(const ChamberFaults& chamber_causes, FaultSet board_causes, bool reset) noexcept;

  FaultSet standing(std::size_t chamber) const noexcept { return chamber_[chamber]; }
  FaultSet standing_on_board() const noexcept { return board_; }
  /// A fault that vents stands at this chamber. `chamber` < kChambers.
  bool must_vent(std::size_t chamber) const noexcept;

 private:
  /// What was present of the causes that clear by themselves.
  struct Recent {
    FaultSet now = 0;     ///< since the last kFlicker_ticks were full
    FaultSet before = 0;  ///< in these
  };
  FaultSet next(const config::Twice<FaultSet>& standing, FaultSet causes, Recent& recent,
                bool reset) const noexcept;

  std::array<config::Twice<FaultSet>, config::kChambers> chamber_{};
  config::Twice<FaultSet> board_;
  std::array<Recent, config::kChambers + 1> recent_{};  ///< of each chamber, and of the board
  std::uint8_t ticks_ = 0;                              ///< since the last kFlicker_ticks were full
};

}  // namespace plenum::safety
