#include "firmware/safety/supervisor.hpp"

namespace plenum::safety {
namespace {

constexpr std::size_t kReactions = 3;  // none, hold, safe

using Row = std::array<Transition, kDemands>;
using Table = std::array<std::array<Row, kReactions>, kStates>;

// The board leaves any state when it is no longer ready.
constexpr Transition NR_v{State::not_ready, Drive::vent};
constexpr Transition IN_s{State::init, Drive::safe};
constexpr Transition DI_s{State::disabled, Drive::safe};
constexpr Transition HO_h{State::hold, Drive::hold};
constexpr Transition AC_a{State::active, Drive::active};
constexpr Transition FR_h{State::fault_reaction, Drive::hold};
constexpr Transition FR_s{State::fault_reaction, Drive::safe};
constexpr Transition FH_h{State::fault_hold, Drive::hold};
constexpr Transition FD_s{State::fault_disabled, Drive::safe};
constexpr Transition FI_s{State::fault_init, Drive::safe};

// clang-format off
constexpr Table kTransitions = {{
    // demand:          not_ready init  disabled hold  active     standing reaction
    /* not_ready */ {{{{NR_v,     IN_s, IN_s,    IN_s, IN_s}},   // none
                      {{NR_v,     FI_s, FI_s,    FI_s, FI_s}},   // hold
                      {{NR_v,     FI_s, FI_s,    FI_s, FI_s}}}}, // safe
    /* init */      {{{{NR_v,     IN_s, DI_s,    DI_s, DI_s}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}}}},
    /* disabled */  {{{{NR_v,     IN_s, DI_s,    HO_h, HO_h}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}}}},
    /* hold */      {{{{NR_v,     IN_s, DI_s,    HO_h, AC_a}},
                      {{NR_v,     FR_s, FR_s,    FR_h, FR_h}},
                      {{NR_v,     FR_s, FR_s,    FR_s, FR_s}}}},
    /* active */    {{{{NR_v,     IN_s, DI_s,    HO_h, AC_a}},
                      {{NR_v,     FR_s, FR_s,    FR_h, FR_h}},
                      {{NR_v,     FR_s, FR_s,    FR_s, FR_s}}}},
    // No reset is accepted in fault_reaction, so its first line is never taken; it leads where nothing moves.
    /* f_reaction */{{{{NR_v,     FI_s, FD_s,    FD_s, FD_s}},
                      {{NR_v,     FI_s, FD_s,    FH_h, FH_h}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}}}},
    // A fault state without a standing fault has just been reset.
    /* f_hold */    {{{{NR_v,     IN_s, DI_s,    HO_h, HO_h}},
                      {{NR_v,     FI_s, FD_s,    FH_h, FH_h}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}}}},
    /* f_disabled */{{{{NR_v,     IN_s, DI_s,    FD_s, FD_s}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}}}},
    /* f_init */    {{{{NR_v,     IN_s, DI_s,    FD_s, FD_s}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}},
                      {{NR_v,     FI_s, FD_s,    FD_s, FD_s}}}},
}};
// clang-format on

struct StateFace {
  std::uint16_t status_word;  // R M H D
  const char* name;
};

constexpr std::array<StateFace, kStates> kFace = {{
    {0b0000, "NOT_READY"},
    {0b1000, "INIT"},
    {0b1001, "DISABLED"},
    {0b1011, "HOLD"},
    {0b1111, "ACTIVE"},
    {0b0111, "FAULT_REACTION"},
    {0b0011, "FAULT_HOLD"},
    {0b0001, "FAULT_DISABLED"},
    {0b0000, "FAULT_INIT"},
}};

constexpr bool set(std::uint16_t word, std::uint16_t bit) noexcept {
  return (word & bit) != 0;
}

// A bit counts only above the bits below it: H without D asks for nothing.
Demand asked(std::uint16_t control_word) noexcept {
  if (!set(control_word, control_bit::kD)) return Demand::init;
  if (!set(control_word, control_bit::kH)) return Demand::disabled;
  return set(control_word, control_bit::kM) ? Demand::active : Demand::hold;
}

Demand possible(const Supervisor::Input& input) noexcept {
  if (!input.ready) return Demand::not_ready;
  const Demand demand = asked(input.control_word);
  return demand > Demand::disabled && !input.model_ready ? Demand::disabled : demand;
}

}  // namespace

const Transition& transition(State from, Reaction reaction, Demand demand) noexcept {
  const Reaction column = reaction == Reaction::vent ? Reaction::safe : reaction;
  return kTransitions[static_cast<std::size_t>(from)][static_cast<std::size_t>(column)]
                     [static_cast<std::size_t>(demand)];
}

std::uint16_t status_word(State state) noexcept {
  const auto row = static_cast<std::size_t>(state);
  return row < kStates ? kFace[row].status_word : std::uint16_t{0};
}

const char* describe(State state) noexcept {
  return kFace[static_cast<std::size_t>(state)].name;
}

bool Supervisor::accepts_reset(std::uint16_t control_word) const noexcept {
  const Demand demand = asked(control_word);
  if (!state_.intact()) return false;
  switch (state_.value()) {
    case State::fault_hold:
      return demand <= Demand::hold;
    case State::fault_disabled:
    case State::fault_init:
      return demand <= Demand::disabled;
    default:
      return false;
  }
}

Supervisor::Output Supervisor::step(const Input& input) noexcept {
  const State from = state_.intact() ? state_.value() : State::not_ready;
  const Transition& row = transition(from, input.reaction, possible(input));
  state_ = row.to;
  return {row.to, row.drive, safety::status_word(row.to)};
}

float resting_command_V(const config::ChamberSettings& settings, Drive drive, bool must_vent) noexcept {
  if (must_vent) return settings.vent_V;
  if (!settings.in_use) return settings.null_V;
  const bool vent = drive == Drive::vent || settings.safe_output == config::SafeOutput::vent;
  return vent ? settings.vent_V : settings.null_V;
}

}  // namespace plenum::safety
