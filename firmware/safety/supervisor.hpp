// The state of a board as CiA 408 has it, by a transition table: state x standing reaction x demand -> state,
// drive.
//
// In every tick, in this order:
//
//   const bool reset = r_has_risen && supervisor.accepts_reset(control_word);
//   const FaultReport report = faults.step(chamber_causes, board_causes, reset);
//   const Supervisor::Output out = supervisor.step({control_word, ready, model_ready, report.reaction});
//
// Invariants (tests/firmware/safety explores every state with every input):
//  - drive `active` only when no fault with a reaction stands, the models are there and D, H and M
//    are commanded;
//  - a fault with reaction safe or vent leaves drive `safe` or `vent` in the very tick in which it appears;
//  - after a fault nothing moves before a reset, and no reset leads to ACTIVE.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/config/chamber_settings.hpp"
#include "firmware/config/twice.hpp"
#include "firmware/safety/faults.hpp"

namespace plenum::safety {

enum class State : std::uint8_t {
  not_ready,       ///< starting: drivers or settings are missing
  init,            ///< parameters may be written
  disabled,        ///< actual values are live
  hold,            ///< regulates to 6394h
  active,          ///< regulates to 6380h
  fault_reaction,  ///< the one tick between regulating and the state that the fault leaves
  fault_hold,      ///< regulates to 6394h
  fault_disabled,
  fault_init
};
inline constexpr std::size_t kStates = 9;

/// What the master asks for, limited by what the board can do.
enum class Demand : std::uint8_t {
  not_ready,  ///< the board itself is not ready, whatever is asked
  init,       ///< D = 0
  disabled,   ///< D = 1; also where a regulated state is asked for and a model is missing
  hold,       ///< D = H = 1
  active      ///< D = H = M = 1
};
inline constexpr std::size_t kDemands = 5;

/// What the outputs do.
enum class Drive : std::uint8_t {
  vent,   ///< vent_V at every chamber
  safe,   ///< the safe output of each chamber
  hold,   ///< regulate to the hold set point; in the excitation mode, which has no model: the safe output
  active  ///< regulate to the set point, or excite
};

/// Bits of the control word 6040h and the status word 6041h.
namespace control_bit {
inline constexpr std::uint16_t kD = 0x1;
inline constexpr std::uint16_t kH = 0x2;
inline constexpr std::uint16_t kM = 0x4;
inline constexpr std::uint16_t kR = 0x8;  ///< 6040h: resets on its rising edge; 6041h: no fault stands
}  // namespace control_bit

struct Transition {
  State to;
  Drive drive;
};

/// The row of the table. `reaction` vent counts as safe.
const Transition& transition(State from, Reaction reaction, Demand demand) noexcept;

/// Low four bits of 6041h: R, M, H, D of CiA 408.
std::uint16_t status_word(State state) noexcept;

const char* describe(State state) noexcept;

class Supervisor {
 public:
  struct Input {
    std::uint16_t control_word = 0;      ///< 6040h
    bool ready = false;                  ///< drivers run, settings are admissible, stored models are loaded
    bool model_ready = false;            ///< each chamber in use has a model, or the control mode needs none
    Reaction reaction = Reaction::none;  ///< of the faults that stand in this tick
  };
  struct Output {
    State state = State::not_ready;
    Drive drive = Drive::vent;
    std::uint16_t status_word = 0;
  };

  /// Where R has risen since the tick before: whether the board is in a fault state, and this word asks for no more than DISABLED, or
  /// HOLD in FAULT_HOLD. So that a reset alone never sets anything in motion, a master first takes M (and H) back.
  bool accepts_reset(std::uint16_t control_word) const noexcept;

  /// One tick.
  Output step(const Input& input) noexcept;

  State state() const noexcept { return state_; }

  /// No bit has flipped in the state. Where one has, no reset is accepted and step() begins at NOT_READY.
  bool intact() const noexcept { return state_.intact(); }

 private:
  config::Twice<State> state_{State::not_ready};
};

/// The command [V] of a chamber that is not regulated: `drive` is vent or safe. `must_vent`: see
/// FaultRegister.
float resting_command_V(const config::ChamberSettings& settings, Drive drive, bool must_vent) noexcept;

}  // namespace plenum::safety
